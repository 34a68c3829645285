"""Stops on streams: a reader that comes back gets each stop and release that it missed, then the present state."""

import asyncio
from collections.abc import Iterable
from contextlib import suppress
from itertools import groupby
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import orjson
from hypothesis import example, given, settings
from hypothesis import strategies as st

from dock_gateway.core.errors import Conflict
from dock_gateway.core.event import Event
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.filters import EventFilter
from dock_gateway.http.parts import Parts
from dock_gateway.latch.interlock import Interlock
from dock_gateway.latch.latch_file import LatchFile
from dock_gateway.latch.latches import Latch
from dock_gateway.settings import Settings
from dock_gateway.stop.stopper import Stopper
from dock_gateway.storage import History
from dock_gateway.streams.current_state import CurrentState
from dock_gateway.streams.feed import begin
from dock_gateway.streams.gateway_state import GatewayState
from tests.support.history import HistoryInMemory

ROBOT = "/robot1"
ALL = "/"
WANTED = EventFilter(topics=frozenset({"goals", "stop"}), robot=ROBOT)
Seen = tuple[bool, str | None]


class Topic:
    def publish(self, *, latched: bool) -> None:
        pass

    def held_by(self) -> None:
        pass

    def let_go(self) -> None:
        pass


class File(LatchFile):
    """The file of the stops, in memory."""

    def __init__(self) -> None:
        super().__init__(Path("stops.json"))
        self._held: dict[str, Latch] = {}

    def read(self) -> dict[str, Latch]:
        return self._held

    def write(self, held: dict[str, Latch]) -> None:
        self._held = held


class Gateway:
    """A gateway of two robots, which remembers each state of one robot's stop."""

    def __init__(self, file: File, history: History) -> None:
        self.fanout = Fanout(queue_limit=10, keep=history.record_event, newest=history.newest)
        self.interlock = Interlock(self.fanout, file, echo_after=60)
        self.parts = Parts({Fanout: self.fanout, History: history, Settings: Settings()})
        self.parts.add(Stopper, SimpleNamespace(state=self.interlock.document))
        self.parts.add(CurrentState, GatewayState(self.parts))
        for robot in (ALL, ROBOT):
            self.interlock.join(robot, Topic(), robot=robot is ROBOT)

    @property
    def state(self) -> Seen:
        document = self.interlock.document(ROBOT)
        return document["latched"], document["by"]

    async def carry_out(self, change: str) -> None:
        match change:
            case "release" | "release all":
                await self.interlock.release(ROBOT if change == "release" else ALL)
            case "hold" | "let go":
                self.interlock.held_by_another(ROBOT, "/button" if change == "hold" else None)
            case "another" | "another releases":
                self.interlock.heard(ROBOT, latched=change == "another", received=float("inf"))
            case by:
                self.interlock.latch(ALL if by.isupper() else ROBOT, by)

    async def resume(self, after: str) -> tuple[list[Event], list[Event]]:
        """Return what a reader gets that comes back: what it missed, and what it gets after that."""
        subscriber = self.fanout.subscribe(WANTED)
        first, *rest = [event async for event in begin(self.parts, subscriber, after)]
        self.fanout.unsubscribe(subscriber)
        resumed = orjson.loads(first.data)
        assert resumed["type"] == "resumed"
        return rest[: resumed["count"]], rest[resumed["count"] :]


def seen(events: Iterable[Event]) -> list[Seen]:
    """Return the states in these events, each once: that a stop is on the disk is a change of it, too."""
    documents: list[dict[str, Any]] = [orjson.loads(event.data) for event in events]
    return [state for state, _ in groupby((each["stop"]["latched"], each["stop"]["by"]) for each in documents)]


CHANGES = ("ada", "grace", "ADA", "release", "release all", "hold", "let go", "another", "another releases")


@settings(max_examples=30, deadline=None)
@given(st.lists(st.tuples(st.sampled_from(CHANGES), st.booleans()), max_size=12))
@example([("ada", False), ("release", False), ("grace", False)])
@example([("ADA", False), ("release", False), ("release all", False), ("ada", True)])
def test_who_comes_back_gets_each_stop_and_release_once_and_in_order(changes: list[tuple[str, bool]]) -> None:
    asyncio.run(check(changes))


async def check(changes: list[tuple[str, bool]]) -> None:
    history, file = HistoryInMemory(), File()
    gateway = Gateway(file, history)
    await asyncio.sleep(0)
    begins = gateway.fanout.position
    live = gateway.fanout.subscribe(WANTED)
    states = [gateway.state]
    for change, pauses in changes:
        with suppress(Conflict):  # such as a release of a robot that another node holds
            await gateway.carry_out(change)
        if gateway.state != states[-1]:
            states.append(gateway.state)
        if pauses:
            await asyncio.sleep(0)
    await asyncio.sleep(0)
    await gateway.interlock.close()
    events, _ = await live.take(0.01)
    assert seen(events) == states[1:]
    positions = [begins, *(event.id or "" for event in events)]
    # Another gateway on the same history knows nothing by itself.
    other = Gateway(file, history)
    for reader in (gateway, other):
        for number, position in enumerate(positions):
            missed, present = await reader.resume(position)
            assert [event.data for event in missed] == [event.data for event in events[number:]]
            (last,) = present
            assert (last.id, seen(present)) == (None, [reader.state])
    await other.interlock.close()
