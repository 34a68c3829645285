"""Watching a camera: read once for all viewers, encoded once for each size, not at all without a viewer."""

import asyncio
import time
from collections.abc import AsyncGenerator, AsyncIterator
from contextlib import AsyncExitStack, aclosing
from types import SimpleNamespace
from typing import Any, cast

import pytest

from dock_gateway.core.errors import GatewayError, NotAllowed, NotFound, Unavailable
from dock_gateway.core.fanout import Fanout, Subscriber
from dock_gateway.core.filters import EventFilter
from dock_gateway.core.grant import UNLIMITED, Grant, Role
from dock_gateway.core.graph import Endpoint, Quality, Topic
from dock_gateway.extensions.cameras import watch as module
from dock_gateway.extensions.cameras.camera import COMPRESSED, Camera, Form
from dock_gateway.extensions.cameras.cameras import Cameras
from dock_gateway.extensions.cameras.picture import JPEG, Picture
from dock_gateway.extensions.cameras.pixels import Unreadable
from dock_gateway.extensions.cameras.settings import CameraSettings
from tests.support.waiting import PATIENCE, until

TOPIC = "/robot1/front/compressed"
FRONT = Camera("front", (Form(TOPIC, COMPRESSED),))
RATE = 60.0


class FakeRelays:
    """Topics on which a test publishes."""

    def __init__(self) -> None:
        self.joined: dict[str, Any] = {}

    async def join(self, topic: str, _: None, outlet: Any) -> None:
        assert topic not in self.joined
        self.joined[topic] = outlet

    async def leave(self, topic: str, outlet: Any) -> None:
        assert self.joined.pop(topic) is outlet

    async def publish(self, data: bytes, ago: float = 0.0) -> None:
        received_ns = int((time.time() - ago) * 1e9)
        await self.joined[TOPIC].offer(SimpleNamespace(topic=TOPIC, data=data, received_ns=received_ns))


class FakePicture(Picture):
    """It is halved by appending to it."""

    def scaled(self, eighths: int, _: int) -> Picture:
        COUNTS.append(f"scaled {eighths}")
        return FakePicture(self.data + b"/%d" % eighths, JPEG, 10 * eighths, 10, 0)


COUNTS: list[str] = []


def read(message: Any, _: int) -> Picture:
    COUNTS.append("read")
    if message.data == b"!":
        raise Unreadable("it is odd")
    return FakePicture(message.data, JPEG, 80, 80, 0)


@pytest.fixture(autouse=True)
def counts(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    monkeypatch.setattr(module, "read_picture", read)
    monkeypatch.setattr(module, "STALE", PATIENCE)  # the machine may be busy
    COUNTS.clear()
    return COUNTS


class Bench:
    """Cameras with a viewer at a time."""

    def __init__(self, stack: AsyncExitStack) -> None:
        self._stack = stack
        self.fanout = Fanout(queue_limit=1)
        self.relays = FakeRelays()
        quality = Quality("reliable", "volatile", "keep_last", 1, None, None, "automatic")
        topic = Topic(TOPIC, [Endpoint("/c", COMPRESSED, quality)], [])

        async def topics_of(_: object, __: str) -> list[Topic]:
            return [topic]

        def get(name: str) -> Any:
            if name != "/robot1":
                raise NotFound("there is no such robot", code="robot_not_found")
            return SimpleNamespace(namespace=name)

        robots = SimpleNamespace(get=get, owner=lambda _: SimpleNamespace(namespace="/robot1"))
        graph = SimpleNamespace(topics_of=topics_of)
        settings = CameraSettings(camera_max_rate=RATE, camera_max_width=80)
        parts = cast("Any", (settings, self.fanout, robots, graph, self.relays))
        self.cameras = Cameras(*parts, first=PATIENCE)
        self.impatient = Cameras(*parts, first=0.2)

    async def viewer(
        self, *, width: int | None = None, patient: bool = True
    ) -> tuple[AsyncGenerator[Picture], Subscriber]:
        subscriber = self.fanout.subscribe(EventFilter(topics=frozenset()))
        pictures = (self.cameras if patient else self.impatient).pictures(FRONT, subscriber, width, None)
        await self._stack.enter_async_context(aclosing(pictures))
        return pictures, subscriber


@pytest.fixture
async def bench() -> AsyncIterator[Bench]:
    async with AsyncExitStack() as stack:
        yield Bench(stack)


async def take(bench: Bench, pictures: AsyncGenerator[Picture], data: bytes) -> bytes:
    """What a viewer gets that waits for a picture when one comes."""
    taken = asyncio.ensure_future(anext(pictures))
    await until(lambda: bool(bench.relays.joined))
    await bench.relays.publish(data)
    return (await taken).data


async def test_each_size_is_encoded_once_for_all_viewers(bench: Bench) -> None:
    (first, _), (second, _), (small, _) = (await bench.viewer(), await bench.viewer(), await bench.viewer(width=40))
    assert await take(bench, first, b"a") == b"a"
    assert (await anext(second)).data == b"a"
    assert (await anext(small)).data == b"a/4"
    assert COUNTS == ["read", "scaled 4"]
    for pictures in (first, second, small):
        assert bench.relays.joined
        await pictures.aclose()
    assert not bench.relays.joined


async def test_a_viewer_that_takes_its_time_gets_the_newest(bench: Bench) -> None:
    pictures, _ = await bench.viewer()
    assert await take(bench, pictures, b"a") == b"a"
    for data in (b"b", b"c", b"d"):
        await bench.relays.publish(data)
    assert (await anext(pictures)).data == b"d"
    assert COUNTS == ["read", "read"]  # what nobody took was not encoded


async def test_an_old_picture_is_not_shown_to_who_comes(bench: Bench) -> None:
    first, _ = await bench.viewer()
    await take(bench, first, b"a")
    await bench.relays.publish(b"old", ago=PATIENCE + 1)
    second, _ = await bench.viewer()
    assert await take(bench, second, b"new") == b"new"


async def test_without_a_picture_there_is_a_reason(bench: Bench) -> None:
    pictures, _ = await bench.viewer(patient=False)
    with pytest.raises(Unavailable, match=r"no picture has come on /robot1/front/compressed within 0\.2 s"):
        await anext(pictures)
    assert not bench.relays.joined


async def test_a_hint_while_pictures_cannot_be_shown(bench: Bench, caplog: pytest.LogCaptureFixture) -> None:
    pictures, _ = await bench.viewer()
    await take(bench, pictures, b"a")
    waiting = asyncio.ensure_future(anext(pictures))
    for number in range(2, 5):
        await bench.relays.publish(b"!")
        await until(lambda count=number: len(COUNTS) == count)  # type: ignore[misc]
    assert not waiting.done()
    assert bench.cameras.hint(FRONT) == "it is odd"
    assert [record.message for record in caplog.records] == [f"{TOPIC} cannot be shown: it is odd"]
    other, _ = await bench.viewer()
    refused = asyncio.ensure_future(anext(other))
    while not refused.done():
        await bench.relays.publish(b"!")
        await asyncio.sleep(0.01)
    with pytest.raises(GatewayError, match="cannot be shown: it is odd"):
        await refused
    waiting.cancel()
    await asyncio.wait([waiting])
    await pictures.aclose()
    again, _ = await bench.viewer()
    taken = asyncio.ensure_future(anext(again))
    await until(lambda: bool(bench.relays.joined))
    await bench.relays.publish(b"!")
    await until(lambda: bench.cameras.hint(FRONT) is not None)
    assert len(caplog.records) == 1  # also for viewers that come again
    await bench.relays.publish(b"b")
    assert (await taken).data == b"b"
    assert bench.cameras.hint(FRONT) is None


async def test_it_ends_when_the_login_ends(bench: Bench) -> None:
    pictures, subscriber = await bench.viewer()
    await take(bench, pictures, b"a")
    subscriber.expel()
    assert await anext(pictures, None) is None
    assert not bench.relays.joined


async def test_it_ends_when_the_gateway_closes(bench: Bench) -> None:
    pictures, _ = await bench.viewer()
    await take(bench, pictures, b"a")
    bench.fanout.close()
    assert await anext(pictures, None) is None


async def test_a_camera_is_found_by_its_name_and_the_grant(bench: Bench) -> None:
    viewer = Grant(Role.VIEWER, topics=("/robot1/back*",))
    assert await bench.cameras.find("/robot1", "front", UNLIMITED) == FRONT
    assert await bench.cameras.all("/robot1", viewer) == []
    with pytest.raises(NotAllowed, match="the camera front"):
        await bench.cameras.find("/robot1", "front", viewer)
    with pytest.raises(NotFound, match="has no camera back"):
        await bench.cameras.find("/robot1", "back", UNLIMITED)
    with pytest.raises(NotFound, match="no such robot"):
        await bench.cameras.all("/robot2", UNLIMITED)
