"""What waits for a client, and when it is sent."""

import asyncio
from types import SimpleNamespace
from typing import Any, cast
from unittest.mock import AsyncMock

import pytest

from dock_gateway.core.errors import TooManyRequests
from dock_gateway.core.work import MEDIUM, MOST, TooLarge, Work
from dock_gateway.extensions.rosbridge.encoding import Payload
from dock_gateway.extensions.rosbridge.protocol import Compression, Subscribe
from dock_gateway.extensions.rosbridge.subscriptions import (
    MAX_SUBSCRIPTIONS,
    QUEUE,
    QUEUE_BYTES,
    RosbridgeSubscriptions,
    TopicOutlet,
)
from dock_gateway.graph.received import Received
from dock_gateway.graph.relays import Relays
from dock_gateway.http.parts import Parts
from tests.support.permits import user


class FakeMessage:
    """A message that is its number. A large one is encoded when `encodes` is set."""

    def __init__(self, number: int, size: int = 10) -> None:
        self.number, self.size = number, size
        self.encodes = asyncio.Event()

    def once(self, _: object) -> "FakeMessage":
        return self

    async def payload(self, compression: Compression, _: Work) -> Payload:
        if self.size > MOST:
            raise TooLarge(self.size)
        if self.size > MEDIUM:
            await self.encodes.wait()
        return Payload.of(f"{self.number}{compression.name}".encode(), binary=False)


def message(number: int, size: int = 10) -> Received:
    made = FakeMessage(number, size)
    made.encodes.set()
    return cast("Received", made)


def outlet(*, writable: bool, **request: Any) -> Any:
    written: list[bytes] = []
    woken: list[None] = []

    def write(frame: bytes) -> bool:
        if writable:
            written.append(frame[2:])
        return writable

    async def send(payload: Payload, _: int | None) -> None:
        written.append(payload.data)

    made = TopicOutlet("/topic", Work(), write, lambda: woken.append(None))
    made.requests[None] = Subscribe(topic="/topic", **request)
    made.configure()
    return SimpleNamespace(end=made, written=written, woken=woken, send_next=lambda: made.send_next(send))


async def test_a_client_that_reads_gets_each_message_at_once() -> None:
    client = outlet(writable=True)
    for number in range(3):
        await client.end.offer(message(number))
    assert client.written == [b"0none", b"1none", b"2none"]
    assert not client.woken


async def test_a_client_that_does_not_read_loses_the_oldest() -> None:
    client = outlet(writable=False)
    for number in range(QUEUE + 5):
        await client.end.offer(message(number))
    await client.send_next()
    assert client.written[-1] == b"5none"
    assert client.woken
    short = outlet(writable=False, queue_length=1)
    for number in range(3):
        await short.end.offer(message(number))
    await short.send_next()
    assert short.written[-1] == b"2none"
    assert short.end.due == float("inf")


async def test_other_readers_do_not_wait_until_a_large_message_is_encoded() -> None:
    client = outlet(writable=True)
    large = FakeMessage(0, MEDIUM + 1)
    async with asyncio.timeout(5):
        await client.end.offer(cast("Received", large))
    assert client.woken
    sending = asyncio.create_task(client.send_next())
    await asyncio.sleep(0)
    await client.end.offer(message(1))  # what comes meanwhile is sent after it
    assert client.written == []
    large.encodes.set()
    await sending
    await client.send_next()
    await client.end.offer(message(2))
    assert client.written == [b"0none", b"1none", b"2none"]


async def test_large_messages_do_not_pile_up() -> None:
    client = outlet(writable=False)
    for number in range(3):
        await client.end.offer(message(number, QUEUE_BYTES))
    await client.send_next()
    assert client.written[-1] == b"2none"
    assert client.end.due == float("inf")


async def test_a_throttled_client_gets_the_newest_when_it_is_due() -> None:
    client = outlet(writable=True, throttle_rate=3_600_000)
    for number in range(3):
        await client.end.offer(message(number))
    assert client.written == [b"0none"]
    assert 0 < client.end.due < float("inf")
    await client.send_next()
    assert client.written[-1] == b"2none"


async def test_several_subscriptions_of_one_topic_share_their_messages() -> None:
    client = outlet(writable=True, throttle_rate=3_600_000)
    client.end.requests["fast"] = Subscribe(topic="/topic", compression="cbor")
    client.end.configure()
    for number in range(2):
        await client.end.offer(message(number))
    assert client.written == [b"0cbor", b"1cbor"]


async def test_a_client_cannot_subscribe_without_end() -> None:
    relays = AsyncMock(Relays)
    parts = Parts({Relays: relays, Work: Work()})
    client, request = RosbridgeSubscriptions(parts, user("ada"), None), Subscribe(topic="/topic")
    for number in range(MAX_SUBSCRIPTIONS):
        await client.subscribe(f"/topic{number % 2}", None, number, request)
    for topic in ("/topic0", "/topic2"):
        with pytest.raises(TooManyRequests, match="subscriptions"):
            await client.subscribe(topic, None, MAX_SUBSCRIPTIONS, request)
    await client.subscribe("/topic0", None, 0, request)  # another setting of one that it has
    await client.unsubscribe("/topic0", 0)
    await client.subscribe("/topic0", None, "new", request)


async def test_what_is_too_large_is_told_once_until_something_comes_through() -> None:
    client = outlet(writable=True)
    said = []
    for size in (MOST + 1, MOST + 2, 10, MOST + 1):
        await client.end.offer(message(1, size))
        if client.end.due <= asyncio.get_running_loop().time():
            await client.send_next()
        said.append(client.end.problem())
    too_large = "a message of 20.0 MB is too large: at most 20 MB are read"
    assert said == [too_large, None, None, too_large]
    assert client.written == [b"1none"]
    assert client.end.due == float("inf")
