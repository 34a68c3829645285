"""Readers that join and leave topics."""

import asyncio
from contextlib import suppress
from typing import Any, cast

import pytest

from dock_gateway.core.graph import Endpoint, Quality, Topic
from dock_gateway.core.work import Work
from dock_gateway.graph.received import Received
from dock_gateway.graph.relays import Relays
from dock_gateway.ros.raw_port import Arrival
from tests.support.bridge import FakeBridge
from tests.support.waiting import PATIENCE, until

KIND = "std_msgs/msg/String"
SLOW = "/slow"

pytestmark = pytest.mark.timeout(PATIENCE)


class FakePort:
    """A subscription that takes the test's `arrivals`, and notes that it was closed."""

    closed: list[str]
    arrivals: dict[str, list[Arrival]]

    def __init__(self, _: object, topic: str, *__: object, **___: object) -> None:
        self._topic = topic

    def keep(self, _: int) -> None:
        """Nothing to keep."""

    def tell_next(self, *_: object) -> None:
        """Nothing to tell: a topic that is joined is read."""

    def take(self) -> list[Arrival]:
        return self.arrivals.pop(self._topic, [])

    def close(self) -> None:
        self.closed.append(self._topic)


class FakeGraph:
    """Knows each topic, by one publisher that keeps its last message."""

    async def topic(self, name: str) -> Topic:
        kept = Quality("reliable", "transient_local", "keep_last", 1, None, None, "automatic")
        return Topic(name, [Endpoint("/talker", KIND, kept)], [])


class Reader:
    """A reader that takes its messages while `reads` is set."""

    def __init__(self, *, reads: bool = True) -> None:
        self.reads = asyncio.Event()
        if reads:
            self.reads.set()
        self.offered: list[Received] = []

    async def offer(self, message: Received) -> None:
        self.offered.append(message)
        await self.reads.wait()


@pytest.fixture
async def relays(monkeypatch: pytest.MonkeyPatch) -> Relays:
    monkeypatch.setattr("dock_gateway.graph.subscription.EchoPort", FakePort)
    FakePort.closed, FakePort.arrivals = [], {}
    return Relays(cast("Any", FakeBridge()), cast("Any", FakeGraph()), Work())


async def start_to_join(relays: Relays, reader: Reader) -> "asyncio.Task[None]":
    """Join a topic that has an earlier message, and wait until the reader has been offered that."""
    FakePort.arrivals[SLOW] = [Arrival(b"1", 1, 2)]
    await relays.join(SLOW, KIND, first := Reader())
    await until(lambda: bool(first.offered))
    joining = asyncio.create_task(relays.join(SLOW, KIND, reader))
    await until(lambda: bool(reader.offered))
    await asyncio.wait_for(relays.leave(SLOW, first), 5)
    return joining


async def test_a_reader_that_takes_its_earlier_messages_slowly_keeps_no_one_waiting(relays: Relays) -> None:
    reader = Reader(reads=False)
    joining = await start_to_join(relays, reader)
    await asyncio.wait_for(relays.join("/other", KIND, other := Reader()), 5)
    await relays.leave("/other", other)
    assert FakePort.closed == ["/other"]
    reader.reads.set()
    await joining
    FakePort.arrivals[SLOW] = [Arrival(b"2", 3, 4)]
    await relays.join(SLOW, KIND, late := Reader())
    await until(lambda: len(reader.offered) == 2)
    await relays.leave(SLOW, late)
    await relays.leave(SLOW, reader)
    assert FakePort.closed == ["/other", SLOW]


@pytest.mark.parametrize("leaves_first", [False, True])
async def test_a_reader_that_gives_up_while_it_joins_leaves_no_subscription(
    relays: Relays, *, leaves_first: bool
) -> None:
    reader = Reader(reads=False)
    joining = await start_to_join(relays, reader)
    if leaves_first:
        await relays.leave(SLOW, reader)
    joining.cancel()
    with suppress(asyncio.CancelledError):
        await joining
    assert joining.cancelled()
    assert FakePort.closed == [SLOW]
