"""What waits for a viewer that reads slowly, and what it is sent."""

import asyncio
import gc
import weakref
from types import SimpleNamespace
from typing import Any, cast
from unittest.mock import AsyncMock

import pytest

from dock_gateway.core.errors import Conflict, TooManyRequests
from dock_gateway.extensions.foxglove.channels import Channel
from dock_gateway.extensions.foxglove.protocol import message_data
from dock_gateway.extensions.foxglove.subscriptions import (
    MAX_SUBSCRIPTIONS,
    FoxgloveSubscriptions,
    Framed,
    Queue,
    Waiting,
)
from dock_gateway.graph.received import Received
from dock_gateway.graph.relays import Relays
from dock_gateway.http.parts import Parts
from dock_gateway.ros.raw_port import Arrival, EchoType
from tests.support.permits import user

KIND = cast("EchoType", SimpleNamespace(name="std_msgs/msg/String"))


def channel(number: int) -> Channel:
    return Channel(number, f"/topic{number}", KIND.name, "string data")


def received(data: bytes, kind: EchoType = KIND) -> Received:
    return Received("/topic", kind, Arrival(data, 0, 7))


def test_the_newest_of_each_topic_is_kept_and_the_oldest_dropped() -> None:
    queue = Queue(most=3)
    for subscription, data in ((1, b"map"), (2, b"a"), (2, b"b"), (2, b"c")):
        queue.put(Waiting(subscription, 0, data))
    assert [queue.pop().data for _ in range(len(queue))] == [b"map", b"b", b"c"]


def test_never_more_bytes_than_a_client_may_have() -> None:
    queue = Queue(most_bytes=10)
    for subscription in range(20):
        queue.put(Waiting(subscription, 0, b"four"))
    assert [queue.pop().subscription for _ in range(len(queue))] == [18, 19]
    queue.put(Waiting(1, 0, b"a"))
    queue.put(Waiting(1, 0, b"longer than there is room"))
    assert [queue.pop().data for _ in range(len(queue))] == [b"longer than there is room"]


def test_what_waits_for_a_subscription_that_ended_is_dropped() -> None:
    queue = Queue(most_bytes=10)
    for subscription in (1, 2, 1):
        queue.put(Waiting(subscription, 0, b"a"))
    queue.forget(1)
    assert [queue.pop().subscription for _ in range(len(queue))] == [2]


class Writer:
    """A connection that takes frames, or not."""

    def __init__(self) -> None:
        self.ready = True
        self.frames: list[bytes] = []

    def write_frame(self, frame: bytes) -> bool:
        if self.ready:
            self.frames.append(frame)
        return self.ready


async def subscribed(writer: Writer, identity: int = 1) -> tuple[FoxgloveSubscriptions, Any]:
    relays = AsyncMock(Relays)
    subscriptions = FoxgloveSubscriptions(Parts({Relays: relays}), user("ada"), writer)
    await subscriptions.subscribe(identity, channel(5))
    return subscriptions, relays.join.await_args.args[2]


async def test_a_client_that_reads_gets_each_message_at_once_and_a_slow_one_in_order() -> None:
    writer, sent = Writer(), list[bytes]()
    subscriptions, outlet = await subscribed(writer)
    await outlet.offer(received(b"first"))
    assert writer.frames[0][2:] == message_data(1, 7, b"first")
    writer.ready = False
    await outlet.offer(received(b"second"))
    writer.ready = True
    await outlet.offer(received(b"third"))  # must not overtake the second
    assert len(writer.frames) == 1

    both = asyncio.Event()

    async def send(message: bytes) -> None:
        sent.append(message)
        if len(sent) == 2:
            both.set()

    sending = asyncio.create_task(subscriptions.send_all(send))
    await both.wait()
    await asyncio.sleep(0)
    assert sent == [message_data(1, 7, b"second"), message_data(1, 7, b"third")]
    await outlet.offer(received(b"fourth"))
    assert len(writer.frames) == 2
    sending.cancel()


async def test_clients_with_the_same_subscription_id_share_a_frame() -> None:
    writers = Writer(), Writer(), Writer()
    outlets = [(await subscribed(writer, identity))[1] for writer, identity in zip(writers, (1, 1, 2), strict=True)]
    message = received(b"data")
    for outlet in outlets:
        await outlet.offer(message)
    one, same, other = (writer.frames[0] for writer in writers)
    assert one is same
    assert other != one


async def test_a_topic_that_has_another_type_by_now_is_another_channel() -> None:
    writer = Writer()
    _, outlet = await subscribed(writer)
    await outlet.offer(received(b"data", cast("EchoType", SimpleNamespace(name="std_msgs/msg/Bool"))))
    assert not writer.frames


async def test_a_client_cannot_subscribe_without_end_or_twice() -> None:
    subscriptions = FoxgloveSubscriptions(Parts({Relays: AsyncMock(Relays)}), user("ada"), None)
    for number in range(MAX_SUBSCRIPTIONS):
        subscriptions.require_room()
        await subscriptions.subscribe(number, channel(number))
    with pytest.raises(TooManyRequests):
        subscriptions.require_room()
    with pytest.raises(Conflict):
        await subscriptions.subscribe(0, channel(1000))
    with pytest.raises(Conflict):
        await subscriptions.subscribe(1000, channel(0))
    await subscriptions.unsubscribe(0)
    subscriptions.require_room()


def test_a_message_that_was_sent_takes_no_memory_any_more() -> None:
    message = received(b"a large map")
    assert message.once(Framed).frame(1, message) is message.once(Framed).frame(1, message)
    gone = weakref.ref(message)
    gc.disable()
    try:
        del message
        assert gone() is None  # at once, without a search for cycles
    finally:
        gc.enable()
