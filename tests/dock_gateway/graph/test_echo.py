"""Topics that somebody looks at: heard once for all of them, shown as often as each wants, counted in full."""

import asyncio
import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import AsyncExitStack
from typing import Any, ClassVar

import orjson
import pytest

from dock_gateway.core.errors import Conflict, NotFound
from dock_gateway.core.fanout import Subscriber
from dock_gateway.core.filters import EventFilter
from dock_gateway.core.graph import Endpoint, Quality, Topic
from dock_gateway.core.work import Work
from dock_gateway.graph import echo as echo_module
from dock_gateway.graph import subscription as module
from dock_gateway.graph.received import Received
from dock_gateway.graph.relays import Relays
from dock_gateway.graph.subscription import KEEP, Listening, listening_for
from dock_gateway.ros.raw_port import Arrival, DecodedMessage, Heard
from tests.support.bridge import FakeBridge
from tests.support.waiting import PATIENCE, until

BOOL, INT = "std_msgs/msg/Bool", "std_msgs/msg/Int32"


def publisher(node: str = "/talker", *, kind: str = BOOL, reliable: bool = True, latched: bool = False) -> Endpoint:
    return Endpoint(
        node,
        kind,
        Quality(
            "reliable" if reliable else "best_effort",
            "transient_local" if latched else "volatile",
            "unknown",
            None,
            None,
            None,
            "automatic",
        ),
    )


class FakeType:
    """Messages are JSON already; `!` cannot be read."""

    read_count = 0

    def __init__(self, name: str) -> None:
        self.name = name
        self.installed = not name.startswith("lift_msgs")
        self.hint = None if self.installed else "install lift_msgs"

    def read(self, message: bytes) -> DecodedMessage:
        FakeType.read_count += 1
        if message == b"!":
            raise ValueError("no such bytes")
        return DecodedMessage(message, {"data": 500} if len(message) > 10 else {}, 0.1 if message == b'"slow"' else 0.0)


class FakePort:
    """Hears what a test says."""

    ports: ClassVar[list["FakePort"]] = []

    def __init__(
        self, _: Any, topic: str, kind: FakeType, *, on_news: Callable[[], None], heard: Heard, keep: int, **how: bool
    ) -> None:
        assert keep in (0, KEEP)
        self.kept = deque[Arrival](maxlen=keep)
        self.topic, self.kind, self.how, self.on_news = topic, kind, how, on_news
        self.heard = heard._replace(newest=None)
        self.closed = False
        self.told = 0
        self.waited_for = True
        FakePort.ports.append(self)

    def close(self) -> None:
        self.closed = True

    def keep(self, keep: int) -> None:
        if keep != self.kept.maxlen:
            self.kept = deque(maxlen=keep)

    def tell_next(self) -> None:
        self.waited_for = True

    def take(self) -> list[Arrival]:
        taken = list(self.kept)
        self.kept.clear()
        return taken

    def say(self, message: bytes) -> None:
        assert not self.closed
        self.kept.append(Arrival(message, 1, 2))
        self.heard = Heard(self.heard.messages + 1, self.heard.size + len(message), message, time.time_ns())
        if self.waited_for:
            self.waited_for = False
            self.told += 1
            self.on_news()


class FakeGraph:
    def __init__(self) -> None:
        self.topics = {f"/t{number}": [publisher()] for number in range(21)}

    async def topic(self, name: str) -> Topic:
        if name not in self.topics:
            raise NotFound("no such topic", code="topic_not_found")
        return Topic(name, self.topics[name], [])


class Viewing:
    """A reader of the echo of a topic."""

    def __init__(self) -> None:
        self.subscriber = Subscriber(256, EventFilter(topics=frozenset()))
        self.events: list[dict[str, Any]] = []

    async def until(self, matches: Callable[[dict[str, Any]], bool]) -> dict[str, Any]:
        async with asyncio.timeout(PATIENCE):
            while True:
                for event in (orjson.loads(event.data) for event in (await self.subscriber.take(PATIENCE))[0]):
                    self.events.append(event)
                for event in self.events:
                    if matches(event):
                        self.events = self.events[self.events.index(event) + 1 :]
                        return event

    async def next(self, kind: str) -> dict[str, Any]:
        return await self.until(lambda event: event["type"] == kind)


@pytest.fixture(autouse=True)
def fakes(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setattr(module, "EchoPort", FakePort)
    monkeypatch.setattr(module, "EchoType", FakeType)
    monkeypatch.setattr(echo_module, "read_message", lambda name, message: FakeType(name).read(message))
    FakePort.ports.clear()
    FakeType.read_count = 0
    yield
    assert all(port.closed for port in FakePort.ports)


@pytest.fixture
def graph() -> FakeGraph:
    return FakeGraph()


@pytest.fixture
def echoes(graph: FakeGraph) -> Relays:
    return Relays(FakeBridge(), graph, Work(), tick=0.05)  # type: ignore[arg-type]


async def test_the_topic_comes_first_then_messages_then_rates(echoes: Relays) -> None:
    viewing = Viewing()
    async with echoes.watch("/t0", viewing.subscriber, 20):
        first = await viewing.next("topic")
        assert (first["message_type"], first["installed"], first["hint"]) == (BOOL, True, None)
        assert first["topic"]["publishers"][0]["node"] == "/talker"
        FakePort.ports[0].say(b'{"a":1}')
        message = await viewing.next("message")
        assert (message["topic"], message["message"], message["abbreviated"], message["lengths"]) == (
            "/t0",
            {"a": 1},
            False,
            {},
        )
        rate = await viewing.until(lambda event: event["type"] == "rate" and event["messages"] == 1)
        assert rate["rate_hz"] > 0
        FakePort.ports[0].say(b'{"a":"long enough"}')
        assert (await viewing.next("message"))["lengths"] == {"data": 500}


async def test_many_who_look_share_one_subscription_and_one_reading(echoes: Relays) -> None:
    viewings = [Viewing() for _ in range(5)]
    async with AsyncExitStack() as stack:
        for viewing in viewings:
            await stack.enter_async_context(echoes.watch("/t0", viewing.subscriber, 20))
        (port,) = FakePort.ports
        port.say(b"1")
        for viewing in viewings:
            assert (await viewing.next("message"))["message"] == 1
        assert FakeType.read_count == 1
        late = Viewing()
        async with echoes.watch("/t0", late.subscriber, 20):
            assert (await late.next("message"))["message"] == 1
        assert not port.closed
    assert port.closed
    async with echoes.watch("/t0", Viewing().subscriber, 20):
        assert len(FakePort.ports) == 2


class Reader:
    """A reader of every message, which takes each while `reads` is set."""

    def __init__(self) -> None:
        self.reads = asyncio.Event()
        self.reads.set()
        self.read: list[bytes] = []

    async def offer(self, message: Received) -> None:
        self.read.append(message.data)
        await self.reads.wait()


@pytest.mark.parametrize("viewed_first", [False, True])
async def test_a_viewer_and_a_reader_share_one_subscription(echoes: Relays, *, viewed_first: bool) -> None:
    viewing, reader = Viewing(), Reader()
    if not viewed_first:
        await echoes.join("/t0", BOOL, reader)
    async with echoes.watch("/t0", viewing.subscriber, 20):
        (port,) = FakePort.ports
        if viewed_first:
            assert port.kept.maxlen == 0  # only the newest message is shown
            port.say(b"0")
            await echoes.join("/t0", BOOL, reader)
        for message in (b"1", b"2", b"3"):
            port.say(message)
        await until(lambda: reader.read == [b"1", b"2", b"3"])
        await viewing.until(lambda event: event["type"] == "message" and event["message"] == 3)
        with pytest.raises(Conflict, match=BOOL):
            await echoes.join("/t0", INT, Reader())
        await echoes.leave("/t0", reader)
        assert port.kept.maxlen == 0
        port.say(b"4")
        await viewing.until(lambda event: event["type"] == "message" and event["message"] == 4)
        rate = await viewing.until(lambda event: event["type"] == "rate")
        assert rate["messages"] == (5 if viewed_first else 4)
    assert port.closed
    assert len(FakePort.ports) == 1


async def test_a_reader_keeps_a_topic_open_whose_viewers_have_left(echoes: Relays) -> None:
    reader = Reader()
    async with echoes.watch("/t0", Viewing().subscriber, 20):
        await echoes.join("/t0", None, reader)
    (port,) = FakePort.ports
    port.say(b"1")
    await until(lambda: reader.read == [b"1"])
    FakeType.read_count = 0
    later = Viewing()
    async with echoes.watch("/t0", later.subscriber, 20):
        assert (await later.next("message"))["message"] == 1
        port.say(b"2")
        rate = await later.until(lambda event: event["type"] == "rate" and event["messages"] > 0)
        assert rate["messages"] == 1  # since it was viewed
    await echoes.leave("/t0", reader)
    assert port.closed


async def test_a_reader_that_takes_long_delays_no_viewer(echoes: Relays) -> None:
    viewing, reader = Viewing(), Reader()
    await echoes.join("/t0", BOOL, reader)
    reader.reads.clear()
    async with echoes.watch("/t0", viewing.subscriber, 20):
        (port,) = FakePort.ports
        for number in (1, 2):
            port.say(str(number).encode())
            assert (await viewing.next("message"))["message"] == number
        assert reader.read == [b"1"]
        reader.reads.set()
        await until(lambda: reader.read == [b"1", b"2"])
    await echoes.leave("/t0", reader)


async def test_a_message_that_takes_long_to_decode_delays_no_reader(
    graph: FakeGraph, monkeypatch: pytest.MonkeyPatch
) -> None:
    decoded = asyncio.Event()

    async def work(_: int, function: Callable[..., Any], *args: Any) -> Any:
        await decoded.wait()
        return function(*args)

    topics = Relays(FakeBridge(), graph, work, tick=0.05)  # type: ignore[arg-type]
    viewing, reader = Viewing(), Reader()
    async with topics.watch("/t0", viewing.subscriber, 20):
        await topics.join("/t0", BOOL, reader)
        (port,) = FakePort.ports
        port.say(b"1")
        await until(lambda: reader.read == [b"1"])
        port.say(b"2")
        await until(lambda: reader.read == [b"1", b"2"])
        decoded.set()
        await viewing.next("message")
    await topics.leave("/t0", reader)


async def test_a_reader_gets_what_a_latched_topic_said_while_it_was_only_viewed(
    echoes: Relays, graph: FakeGraph
) -> None:
    graph.topics["/t0"] = [publisher(latched=True)]
    viewing, reader = Viewing(), Reader()
    async with echoes.watch("/t0", viewing.subscriber, 20):
        (port,) = FakePort.ports
        port.say(b"1")
        await viewing.next("message")
        await echoes.join("/t0", BOOL, reader)
        await until(lambda: reader.read == [b"1"])
        assert len(FakePort.ports) == 1
        await echoes.leave("/t0", reader)


async def test_each_gets_the_newest_as_often_as_it_wants(echoes: Relays) -> None:
    slow, fast = Viewing(), Viewing()
    async with echoes.watch("/t0", slow.subscriber, 2), echoes.watch("/t0", fast.subscriber, 20):
        (port,) = FakePort.ports
        began = time.monotonic()
        for number in range(300):
            port.say(str(number).encode())
            await asyncio.sleep(0.002)
        took = time.monotonic() - began
        for viewing in (slow, fast):
            await viewing.until(lambda event: event["type"] == "message" and event["message"] == 299)
        assert FakeType.read_count <= 22 * took + 2 * took + 5
        assert port.told <= FakeType.read_count + 2  # the loop is not woken for each message
        await fast.until(lambda event: event["type"] == "rate" and event["messages"] == 300)


async def test_what_takes_long_to_read_is_read_seldom(echoes: Relays) -> None:
    viewing = Viewing()
    async with echoes.watch("/t0", viewing.subscriber, 20):
        FakePort.ports[0].say(b"[1]")
        await viewing.next("message")
        FakePort.ports[0].say(b'"slow"')
        await viewing.next("message")
        FakePort.ports[0].say(b"[2]")
        for _ in range(8):  # 0.4 s: long after the viewer would be due again
            await viewing.next("rate")
        assert FakeType.read_count == 2


async def test_messages_that_cannot_be_read_are_said_to_be(echoes: Relays) -> None:
    viewing = Viewing()
    async with echoes.watch("/t0", viewing.subscriber, 20):
        await viewing.next("topic")
        FakePort.ports[0].say(b"!")
        assert "cannot be read" in (await viewing.next("topic"))["hint"]
        FakePort.ports[0].say(b"2")
        assert (await viewing.next("topic"))["hint"] is None
        assert (await viewing.next("message"))["message"] == 2


async def test_of_a_package_that_is_missing_nothing_is_heard(echoes: Relays, graph: FakeGraph) -> None:
    graph.topics["/lift"] = [publisher(kind="lift_msgs/msg/LiftState")]
    viewing = Viewing()
    async with echoes.watch("/lift", viewing.subscriber, 20):
        first = await viewing.next("topic")
        assert (first["installed"], first["hint"]) == (False, "install lift_msgs")
        with pytest.raises(TimeoutError):
            async with asyncio.timeout(0.3):  # six ticks
                await viewing.next("rate")
        assert FakeType.read_count == 0
        with pytest.raises(NotFound) as refused:
            await echoes.join("/lift", None, Reader())
        assert refused.value.code == "interface_not_found"
        assert not FakePort.ports[0].closed


async def test_other_publishers_are_heard_as_they_need_it_and_counting_goes_on(
    echoes: Relays, graph: FakeGraph
) -> None:
    viewing = Viewing()
    graph.topics["/t0"] = [publisher(latched=True)]
    async with echoes.watch("/t0", viewing.subscriber, 20):
        await viewing.next("topic")
        assert FakePort.ports[0].how == {"reliable": True, "latched": True}
        FakePort.ports[0].say(b"1")
        await viewing.next("message")
        graph.topics["/t0"] = [publisher(), publisher("/other", reliable=False)]
        assert len((await viewing.next("topic"))["topic"]["publishers"]) == 2
        first, second = FakePort.ports
        assert first.closed
        assert second.how == {"reliable": False, "latched": False}
        second.say(b"2")
        assert (await viewing.next("message"))["message"] == 2
        await viewing.until(lambda event: event["type"] == "rate" and event["messages"] == 2)

        graph.topics["/t0"] = [publisher(kind=INT, reliable=False)]
        assert (await viewing.next("topic"))["message_type"] == INT
        del graph.topics["/t0"]
        gone = await viewing.next("topic")
        assert (gone["message_type"], gone["topic"]["publishers"]) == (INT, [])
        assert len(FakePort.ports) == 3


async def test_no_such_topic(echoes: Relays) -> None:
    with pytest.raises(NotFound):
        async with echoes.watch("/nope", Viewing().subscriber, 5):
            pass
    assert FakePort.ports == []


async def test_one_that_is_looked_at_when_the_gateway_closes(echoes: Relays) -> None:
    async with echoes.watch("/t0", Viewing().subscriber, 5):
        await echoes.close()
        assert FakePort.ports[0].closed


NOW = Listening(INT, reliable=True, latched=True)


@pytest.mark.parametrize(
    ("publishers", "now", "expected"),
    [
        ([publisher()], None, Listening(BOOL, reliable=True, latched=False)),
        ([publisher(latched=True)], None, Listening(BOOL, reliable=True, latched=True)),
        ([publisher(latched=True, reliable=False)], None, Listening(BOOL, reliable=False, latched=True)),
        ([publisher(), publisher(reliable=False)], None, Listening(BOOL, reliable=False, latched=False)),
        ([publisher(latched=True), publisher()], None, Listening(BOOL, reliable=True, latched=False)),
        ([publisher(kind=INT), publisher()], None, Listening(BOOL, reliable=True, latched=False)),
        ([publisher()], NOW, Listening(BOOL, reliable=True, latched=False)),
        ([], NOW, NOW),
        ([], None, Listening(INT, reliable=False, latched=False)),
    ],
)
def test_how_a_topic_is_listened_to(publishers: list[Endpoint], now: Listening | None, expected: Listening) -> None:
    assert listening_for(Topic("/t", publishers, [publisher(kind=INT)]), now) == expected
