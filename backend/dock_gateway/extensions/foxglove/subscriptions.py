"""The subscriptions of one client, and its queue of messages if it reads slowly."""

import asyncio
from collections import Counter, deque
from collections.abc import Awaitable, Callable
from typing import NamedTuple

from dock_gateway.core.access import Principal
from dock_gateway.core.errors import Conflict, TooManyRequests
from dock_gateway.core.event import websocket_frame
from dock_gateway.core.fanout import FrameWriter
from dock_gateway.extensions.foxglove.channels import Channel
from dock_gateway.extensions.foxglove.protocol import message_data
from dock_gateway.graph.received import Received
from dock_gateway.http.parts import Parts
from dock_gateway.operations.topics import ReadTopic
from dock_gateway.streams.topic_readings import TopicReadings

MAX_SUBSCRIPTIONS = 100
# Messages and bytes that wait for a client that reads slowly.
QUEUE, QUEUE_BYTES = 1000, 16_000_000


class Framed:
    """A message as a WebSocket frame. Clients with the same subscription id, such as those of one layout, share it."""

    def __init__(self, _: Received) -> None:  # the message has this, so this must not have the message
        self._subscription = -1
        self._frame = b""

    def frame(self, subscription: int, message: Received) -> bytes:
        """Return the frame for a subscription id. Only the last one is kept: a map may have megabytes."""
        if subscription != self._subscription:
            self._subscription = subscription
            self._frame = websocket_frame(Waiting.of(subscription, message).payload(), binary=True)
        return self._frame


class Waiting(NamedTuple):
    """A message for a client."""

    subscription: int
    received_ns: int
    data: bytes

    @classmethod
    def of(cls, subscription: int, message: Received) -> "Waiting":
        """Return a message for a subscription."""
        return cls(subscription, message.received_ns, message.data)

    def payload(self) -> bytes:
        """Return what the client is sent."""
        return message_data(self.subscription, self.received_ns, self.data)


class Queue:
    """The queue of one client: the newest message of each topic, and earlier ones while there is room.

    Args:
        most: Maximum number of messages.
        most_bytes: Maximum number of bytes; one message may have more.
    """

    def __init__(self, most: int = QUEUE, most_bytes: int = QUEUE_BYTES) -> None:
        self._most = most
        self._most_bytes = most_bytes
        self._messages: deque[Waiting] = deque()
        self._counts: Counter[int] = Counter()
        self._bytes = 0

    def __len__(self) -> int:
        return len(self._messages)

    def put(self, message: Waiting) -> None:
        """Add a message. Drop the oldest ones that are not the newest of their topic; then the oldest ones."""
        self._messages.append(message)
        self._counts[message.subscription] += 1
        self._bytes += len(message.data)
        while len(self._messages) > self._most or (self._bytes > self._most_bytes and len(self._messages) > 1):
            self._drop(next((at for at, each in enumerate(self._messages) if self._counts[each.subscription] > 1), 0))

    def pop(self) -> Waiting:
        """Return the oldest message."""
        return self._drop(0)

    def forget(self, subscription: int) -> None:
        """Drop all messages of a subscription."""
        for at in reversed(range(len(self._messages))):
            if self._messages[at].subscription == subscription:
                self._drop(at)

    def _drop(self, at: int) -> Waiting:
        message = self._messages[at]
        del self._messages[at]
        self._counts[message.subscription] -= 1
        self._bytes -= len(message.data)
        return message


class ChannelOutlet:
    """One channel for one client."""

    def __init__(self, channel: Channel, put: Callable[[Received], None]) -> None:
        self.channel = channel
        self._put = put

    async def offer(self, message: Received) -> None:
        """Pass a message on, unless the topic has another type by now, which is another channel."""
        if message.kind.name == self.channel.type:
            self._put(message)


class FoxgloveSubscriptions:
    """All subscriptions of one client.

    Args:
        parts: Carry out the operations.
        principal: The user.
        writer: Writes frames past the queue; None if the connection cannot.
    """

    def __init__(self, parts: Parts, principal: Principal, writer: FrameWriter | None) -> None:
        self._readings = TopicReadings(parts, principal, writer)
        self._outlets: dict[int, ChannelOutlet] = {}
        self._queue = Queue()
        self._waiting = asyncio.Event()
        self._sending = False  # something waits, or is just being sent

    def require_room(self) -> None:
        """Refuse more subscriptions than a client may have.

        Raises:
            TooManyRequests: It has them already.
        """
        if len(self._outlets) >= MAX_SUBSCRIPTIONS:
            raise TooManyRequests(f"this connection already has {MAX_SUBSCRIPTIONS} subscriptions")

    async def subscribe(self, identity: int, channel: Channel) -> None:
        """Send the messages of a channel.

        Raises:
            Conflict: The id is in use, or the channel has a subscription.
            GatewayError: As `operations.subscribe`.
        """
        if identity in self._outlets:
            raise Conflict(f"the subscription {identity} already exists", code="subscription_exists")
        if any(each.channel.id == channel.id for each in self._outlets.values()):
            raise Conflict(f"the channel {channel.id} ({channel.topic}) is subscribed to", code="subscription_exists")
        outlet = ChannelOutlet(channel, lambda message: self._put(identity, message))
        order = ReadTopic(channel.topic, outlet, channel.type)
        await self._readings.begin(identity, order)
        self._outlets[identity] = outlet

    async def unsubscribe(self, identity: int) -> bool:
        """End a subscription; return whether there was one."""
        if self._outlets.pop(identity, None) is None:
            return False
        await self._readings.end(identity)
        self._queue.forget(identity)  # its id may be used again
        return True

    async def leave(self, channel: Channel) -> None:
        """End the subscription of a channel that is gone."""
        for identity, outlet in list(self._outlets.items()):
            if outlet.channel.id == channel.id:
                await self.unsubscribe(identity)

    def _put(self, subscription: int, message: Received) -> None:
        if self._sending or not self._readings.write(message.once(Framed).frame(subscription, message)):
            self._queue.put(Waiting.of(subscription, message))
            self._waiting.set()
            self._sending = True

    async def send_all(self, send: Callable[[bytes], Awaitable[None]]) -> None:
        """Send what waits, for as long as the client is connected."""
        while True:
            await self._waiting.wait()
            self._waiting.clear()
            while len(self._queue):
                await send(self._queue.pop().payload())
            self._sending = False

    async def close(self) -> None:
        """End all subscriptions."""
        for identity in list(self._outlets):
            await self.unsubscribe(identity)
