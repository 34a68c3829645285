"""One subscription for all readers of a topic."""

import asyncio
from collections.abc import Callable
from typing import Any, cast

import pytest

from dock_gateway.core.errors import Unavailable
from dock_gateway.core.graph import Topic
from dock_gateway.core.work import Work
from dock_gateway.graph.received import Received
from dock_gateway.graph.relay import Relay
from dock_gateway.graph.subscription import KEEP
from dock_gateway.ros.raw_port import Arrival
from tests.support.bridge import FakeBridge
from tests.support.waiting import PATIENCE

FIRST, SECOND = b"1", b"22"


class FakePort:
    """A subscription whose second message arrives just after the first one was taken."""

    def __init__(self, *_: object, on_news: Callable[[], None], **__: object) -> None:
        self._on_news = on_news
        self._told = False
        self._kept: list[Arrival] = []
        self._coming = [FIRST]

    def hear(self, message: bytes) -> None:
        self._kept.append(Arrival(message, 1, 2))
        if not self._told:
            self._told = True
            asyncio.get_running_loop().call_soon(self._on_news)

    def keep(self, keep: int) -> None:
        assert keep == KEEP

    def tell_next(self) -> None:
        self._told = False

    def take(self) -> list[Arrival]:
        taken, self._kept = self._kept, []
        if self._coming:
            asyncio.get_running_loop().call_soon(self.hear, self._coming.pop())  # when the relay waits
        if any(arrival.data == FIRST for arrival in taken):
            self.hear(SECOND)
        return taken

    def close(self) -> None:
        """Nothing to close."""


class Listener:
    """A client that notes the sizes of its messages."""

    def __init__(self, *, patient: bool) -> None:
        self.patient = patient
        self.sizes: asyncio.Queue[int] = asyncio.Queue()

    async def offer(self, message: Received) -> None:
        self.sizes.put_nowait(message.size)


@pytest.mark.parametrize("patient", [False, True])
async def test_no_message_waits_for_the_next_one(monkeypatch: pytest.MonkeyPatch, *, patient: bool) -> None:
    monkeypatch.setattr("dock_gateway.graph.subscription.EchoPort", FakePort)
    relay = Relay(cast("Any", FakeBridge()), cast("Any", None), Topic("/chatter", [], []), Work(), tick=3600.0)
    listener = Listener(patient=patient)
    relay.join(listener)
    await relay.add(listener)
    await relay.open("std_msgs/msg/String")
    try:
        assert await asyncio.wait_for(listener.sizes.get(), PATIENCE) == len(FIRST)
        assert await asyncio.wait_for(listener.sizes.get(), PATIENCE) == len(SECOND)
    finally:
        await relay.close()


class Faulty:
    """A reader with a mistake."""

    def __init__(self, error: Exception) -> None:
        self.error = error
        self.offered = 0

    async def offer(self, _: Received) -> None:
        self.offered += 1
        raise self.error


@pytest.mark.parametrize(("error", "offered"), [(ZeroDivisionError(), 1), (Unavailable("busy"), 2)])
async def test_a_reader_that_fails_holds_up_no_other(
    monkeypatch: pytest.MonkeyPatch, error: Exception, offered: int
) -> None:
    monkeypatch.setattr("dock_gateway.graph.subscription.EchoPort", FakePort)
    relay = Relay(cast("Any", FakeBridge()), cast("Any", None), Topic("/chatter", [], []), Work(), tick=3600.0)
    faulty, listeners = Faulty(error), [Listener(patient=False) for _ in range(8)]
    for reader in (*listeners[:4], faulty, *listeners[4:]):
        relay.join(reader)
        await relay.add(reader)
    await relay.open("std_msgs/msg/String")
    try:
        for listener in listeners:
            sizes = [await asyncio.wait_for(listener.sizes.get(), PATIENCE) for _ in range(2)]
            assert sizes == [len(FIRST), len(SECOND)]
    finally:
        await relay.close()
    assert faulty.offered == offered
