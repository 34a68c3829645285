"""A client that reads a stream, wherever a gateway is."""

import asyncio
import contextlib
from collections import Counter
from collections.abc import Callable, Sequence

import orjson

from dock_gateway.core.errors import GatewayError
from dock_gateway.core.filters import EventFilter
from dock_gateway.streams import feed
from tests.dock_gateway.simulation.chance import Chance, short
from tests.dock_gateway.simulation.process import Process


class Reader:
    """Reads every event, and resumes after the last one: at another gateway, if its own is gone.

    Attributes:
        seen: What it got: the process, and the event's id, type and goal.
        notices: How many notices it got, by type.
    """

    def __init__(self, chance: Chance, gateways: Callable[[], Sequence[Process]], since: str) -> None:
        self._chance = chance
        self._gateways = gateways
        self.seen: list[tuple[str, str, str, str]] = []
        self._since = since
        self.notices: Counter[str] = Counter()
        self._move = False
        self._expelled = lambda: None

    def move(self) -> None:
        """Leave this gateway for another."""
        self._move = True
        self._expelled()

    async def run(self) -> None:
        at: Process | None = None
        while True:
            others = [gateway for gateway in self._gateways() if gateway.ready and not gateway.dead]
            if at is not None and self._move:
                others = [gateway for gateway in others if gateway is not at] or others
            self._move = False
            if not others:
                await asyncio.sleep(0.02)
                continue
            at = self._chance.random.choice(others)
            await asyncio.sleep(self._chance.latency())
            with contextlib.suppress(GatewayError):
                await self._read(at)

    async def _read(self, gateway: Process) -> None:
        last = max((identity for _, identity, _, _ in self.seen), default=self._since)
        self._chance.say("reader", f"at {gateway.name} after {short(last)}")
        subscriber = gateway.fanout.subscribe(EventFilter(frozenset({"goals", "battery"})))
        self._expelled = subscriber.expel
        stream = feed.feed(gateway.parts, subscriber, after=last)
        try:
            async for event in stream:
                if gateway.dead or self._move:
                    return
                document = orjson.loads(event.data)
                if event.id is None or document["type"] in ("snapshot", "heartbeat"):  # their id is a position
                    self.notices[document["type"]] += 1
                    continue
                kind = document["type"]
                if kind != "battery":
                    kind += f" {document.get('status', '')}"
                self.seen.append((gateway.name, event.id, kind, document.get("goal_id", "")))
                self._chance.say("reader", f"gets {short(event.id)} {kind}")
        finally:
            gateway.fanout.unsubscribe(subscriber)
