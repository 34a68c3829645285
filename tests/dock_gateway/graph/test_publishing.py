"""Messages whose publisher leaves while it reaches the subscribers: each is answered, and none is sent late."""

import asyncio
from types import SimpleNamespace
from typing import Any

import pytest

from dock_gateway.core.errors import Conflict, Unavailable
from dock_gateway.graph import publishing
from dock_gateway.graph.publishing import FoundTopic, Publishing
from dock_gateway.settings import Settings
from tests.support.waiting import PATIENCE

TOPIC = "/robot1/speed"


class FakePort:
    """A publisher that reaches its subscribers when it is told to."""

    def __init__(self) -> None:
        self.open, self.subscribers = True, 1
        self.sent: list[object] = []
        self.found = asyncio.Event()

    async def reach(self, _: int) -> None:
        await self.found.wait()

    def publish(self, message: object) -> None:
        self.sent.append(message)

    def close(self) -> None:
        self.open = False


class World:
    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.ports: list[FakePort] = []
        self.stopped = False
        monkeypatch.setattr(publishing, "TopicPort", lambda *_, **__: self.ports.append(FakePort()) or self.ports[-1])
        monkeypatch.setattr(publishing.TopicPort, "close", FakePort.close, raising=False)
        monkeypatch.setattr(Publishing, "find", self.find)
        bridge, interlock = SimpleNamespace(call=self.call), SimpleNamespace(require_released=self.require_released)
        self.publishing = Publishing(Settings(allow_publish="/*"), bridge, interlock)  # type: ignore[arg-type]

    @staticmethod
    async def call(function: Any, **_: Any) -> Any:
        return function()

    @staticmethod
    async def find(_: Publishing, name: str, type_name: str | None, __: Any) -> FoundTopic:
        kind = type_name or "std_msgs/msg/Float64"
        return FoundTopic(name, kind, (kind,), latched=False, subscribers=1)

    def require_released(self, *_: str) -> None:
        if self.stopped:
            raise Conflict("it was stopped", code="stop_latched")

    async def begin(self, type_name: str | None = None) -> "asyncio.Task[Any]":
        """Publish a message that waits for its subscribers."""
        before = len(self.ports)
        task = asyncio.create_task(self.publishing.publish(TOPIC, {}, type_name=type_name))
        async with asyncio.timeout(PATIENCE):
            while len(self.ports) == before:  # noqa: ASYNC110 - nothing tells it
                await asyncio.sleep(0)
        return task


@pytest.fixture
def world(monkeypatch: pytest.MonkeyPatch) -> World:
    return World(monkeypatch)


async def test_a_stop_refuses_the_messages_that_wait_for_their_subscribers(world: World) -> None:
    waiting = [await world.begin(), asyncio.create_task(world.publishing.publish(TOPIC, {}))]
    world.stopped = True
    world.publishing.withdraw("/robot1")
    for result in await asyncio.gather(*waiting, return_exceptions=True):
        assert isinstance(result, Conflict)
    assert not world.ports[0].sent


async def test_a_message_from_before_a_stop_is_not_sent_after_its_release(world: World) -> None:
    waiting = await world.begin()
    world.publishing.withdraw("/robot1")
    with pytest.raises(Unavailable, match="try again"):
        await waiting
    assert not world.ports[0].sent


async def test_a_second_message_waits_for_the_subscribers_too(world: World) -> None:
    first = await world.begin()
    second = asyncio.create_task(world.publishing.publish(TOPIC, {}))
    await asyncio.sleep(0.05)
    assert not second.done()
    world.ports[0].found.set()
    await asyncio.gather(first, second)
    assert len(world.ports[0].sent) == 2


async def test_another_type_takes_the_place_of_a_publisher(world: World) -> None:
    first = await world.begin()
    second = await world.begin("std_msgs/msg/Bool")
    with pytest.raises(Unavailable, match="try again"):
        await first
    world.ports[1].found.set()
    assert (await second).type == "std_msgs/msg/Bool"
