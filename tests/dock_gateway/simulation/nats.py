"""A NATS server and its connections: it loses, repeats and reorders messages, and cuts connections."""

import asyncio
from collections import defaultdict
from collections.abc import Awaitable, Callable
from contextvars import Context
from dataclasses import dataclass
from typing import Any

from nats import errors

from dock_gateway.sites.nats_client import ConnectFailed
from tests.dock_gateway.simulation.chance import TICK, Chance

Handler = Callable[[Any], Awaitable[None]]


@dataclass(frozen=True)
class Message:
    """A message as nats-py hands it out."""

    subject: str
    data: bytes
    reply: str = ""
    headers: dict[str, str] | None = None


class Subscription:
    """What one connection wants of a subject."""

    def __init__(self, server: "NatsServer", pattern: str, handler: Handler) -> None:
        self._server = server
        self._pattern = pattern.split(".")
        self._queue: asyncio.Queue[Message] = asyncio.Queue()
        self.put = self._queue.put_nowait
        self._task = asyncio.create_task(self._hand_over(handler))

    async def _hand_over(self, handler: Handler) -> None:
        while True:
            await handler(await self._queue.get())

    def wants(self, subject: str) -> bool:
        parts = subject.split(".")
        if self._pattern[-1] == ">":
            parts = [*parts[: len(self._pattern) - 1], ">"]
        return len(parts) == len(self._pattern) and all(
            want in ("*", part) for want, part in zip(self._pattern, parts, strict=True)
        )

    async def unsubscribe(self) -> None:
        self._server.subscriptions.pop(self, None)
        self._task.cancel()


class NatsServer:
    """The server, through which everything goes.

    Attributes:
        lost: Number of messages that never arrived.
        repeated: Number of those that arrived twice.
        reordered: Number of those that others overtook.
    """

    def __init__(self, chance: Chance) -> None:
        self._chance = chance
        self.subscriptions: dict[Subscription, None] = {}
        self.connections: dict[NatsConnection, None] = {}
        self.down_until = 0.0
        self.lost = self.repeated = self.reordered = 0
        self._busy_until: defaultdict[Subscription, float] = defaultdict(float)

    def publish(self, message: Message) -> None:
        wanting = [each for each in self.subscriptions if each.wants(message.subject)]
        for subscription in wanting:
            self._send(subscription, message)
        if not wanting and message.reply:
            self.publish(Message(message.reply, b"", headers={"Status": "503"}))

    def _send(self, subscription: Subscription, message: Message) -> None:
        draw, odds = self._chance.random, self._chance.faults
        now = self._chance.loop.time()
        if draw.random() < odds.loss:
            self.lost += 1
            return
        at = max(now + self._chance.latency(), self._busy_until[subscription] + TICK)
        if draw.random() < odds.reorder:
            self.reordered += 1
            at += draw.uniform(0.0, 0.05)
        else:
            self._busy_until[subscription] = at
        times = [at]
        if draw.random() < odds.repeat:
            self.repeated += 1
            times.append(at + draw.uniform(0.0, 0.5))
        for each in times:
            self._chance.loop.call_at(each, subscription.put, message, context=Context())

    def cut(self, seconds: float) -> None:
        """Lose all connections, and take none for a while."""
        self._chance.say("nats", f"away for {seconds:.3f} s")
        self.down_until = self._chance.loop.time() + seconds
        for connection in list(self.connections):
            connection.lost.set()
            connection.drop()

    def connect(self, server: object) -> "NatsConnection":
        """Return a connection that is still to be started, as the class `NatsClient` does."""
        return NatsConnection(self, self._chance, server)


class NatsConnection:
    """One connection; see `dock_gateway.sites.nats_client.NatsClient`."""

    max_payload = 1024 * 1024
    pending_data_size = 0

    def __init__(self, nats: NatsServer, chance: Chance, server: object) -> None:
        self.server = server
        self.lost = asyncio.Event()
        self.reason = ""
        self._nats = nats
        self._chance = chance
        self._subscriptions: list[Subscription] = []

    @property
    def usable(self) -> bool:
        return self in self._nats.connections and not self.lost.is_set()

    async def start(self, **_: object) -> None:
        await asyncio.sleep(self._chance.latency())
        if self._chance.loop.time() < self._nats.down_until:
            raise ConnectFailed("it is away")
        self._nats.connections[self] = None

    async def rtt(self, timeout: float) -> float:
        await asyncio.sleep(self._chance.latency())
        if not self.usable:
            raise errors.TimeoutError
        return 0.0

    async def subscribe(self, subject: str, *, cb: Handler, **_: object) -> Subscription:
        subscription = Subscription(self._nats, subject, cb)
        self._subscriptions.append(subscription)
        self._nats.subscriptions[subscription] = None
        return subscription

    async def publish(self, subject: str, data: bytes, reply: str = "") -> None:
        if not self.usable:
            raise errors.ConnectionClosedError
        self._nats.publish(Message(subject, data, reply))

    def drop(self) -> None:
        """Forget the connection at the server."""
        self._nats.connections.pop(self, None)
        for subscription in self._subscriptions:
            self._nats.subscriptions.pop(subscription, None)

    async def abandon(self) -> None:
        self.lost.set()
        self.drop()
        for subscription in self._subscriptions:
            await subscription.unsubscribe()
