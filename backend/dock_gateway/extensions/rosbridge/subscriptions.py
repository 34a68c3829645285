"""A client's subscriptions: what waits for it, and when it may be sent."""

import asyncio
from collections import deque
from collections.abc import Awaitable, Callable

from dock_gateway.core.access import Principal
from dock_gateway.core.errors import TooManyRequests
from dock_gateway.core.fanout import FrameWriter
from dock_gateway.core.work import MEDIUM, TooLarge, Work
from dock_gateway.extensions.rosbridge.encoding import Payload
from dock_gateway.extensions.rosbridge.protocol import Compression, Identity, Subscribe
from dock_gateway.extensions.rosbridge.published import Published
from dock_gateway.graph.received import Received
from dock_gateway.http.parts import Parts
from dock_gateway.operations.topics import ReadTopic
from dock_gateway.streams.topic_readings import TopicReadings

# Topics of a client, and its subscriptions of all of them together.
MAX_TOPICS, MAX_SUBSCRIPTIONS = 64, 500
# Messages and bytes of one topic that wait for a client that reads slowly. The oldest are dropped.
QUEUE, QUEUE_BYTES = 100, 16_000_000
NEVER = float("inf")


class TopicOutlet:
    """One topic for one client, which may have subscribed to it more than once.

    Args:
        topic: Absolute name.
        work: Encodes messages.
        write: Writes a frame at once, if nothing waits; returns whether it did.
        wake: Called when a message or a problem waits.
    """

    def __init__(self, topic: str, work: Work, write: Callable[[bytes], bool], wake: Callable[[], None]) -> None:
        self.topic = topic
        self._work = work
        self._too_large: str | None = None
        self._told: str | None = None
        self.requests: dict[Identity, Subscribe] = {}
        self.compression = Compression.none
        self.fragment_size: int | None = None
        self._write = write
        self._wake = wake
        self._period = 0.0
        self._limit = QUEUE
        self._due = 0.0
        self._size = 0
        self._queue: deque[Published] = deque()
        self._sending = False

    def configure(self) -> None:
        """Take what suits all subscriptions: the shortest period, the smallest fragments, the greatest compression."""
        requests = self.requests.values()
        self._period = min(request.throttle_rate for request in requests) / 1000
        length = min(request.queue_length for request in requests)
        self._limit = min(QUEUE, length or (1 if self._period else QUEUE))
        self.compression = max(Compression.named(request.compression) for request in requests)
        self.fragment_size = min((each.fragment_size for each in requests if each.fragment_size), default=None)

    @property
    def due(self) -> float:
        """The time when the next message may be sent, by the clock of the loop; never without one."""
        return self._due if self._queue else NEVER

    async def offer(self, received: Received) -> None:
        """Send a message now if that is possible, else keep it, as a large one: other readers do not wait for it."""
        message = received.once(Published)
        # Messages in CBOR with their ROS bytes are only copied.
        quick = message.size <= MEDIUM or self.compression is Compression.cbor_raw
        if quick and not self._queue and not self._sending and self._due <= _now():
            payload = await self._encode(message)
            if payload is None:
                return
            whole = self.fragment_size is None or payload.binary or payload.size <= self.fragment_size
            if whole and not self._queue and self._write(payload.frame):
                self._due = _now() + self._period
                return
        self._queue.append(message)
        self._size += message.size
        while len(self._queue) > self._limit or (self._size > QUEUE_BYTES and len(self._queue) > 1):
            self._size -= self._queue.popleft().size
        self._wake()

    async def send_next(self, send: Callable[[Payload, int | None], Awaitable[None]]) -> None:
        """Send the next message, which has to be due, in pieces of a size; not one that cannot be read."""
        message = self._queue.popleft()
        self._size -= message.size
        self._due = _now() + self._period
        self._sending = True  # what comes meanwhile is sent after it
        try:
            if (payload := await self._encode(message)) is not None:
                await send(payload, self.fragment_size)
        finally:
            self._sending = False

    async def _encode(self, message: Published) -> Payload | None:
        try:
            payload = await message.payload(self.compression, self._work)
        except TooLarge as error:
            self._too_large = str(error)
            self._wake()
            return None
        self._too_large = None
        return payload

    def problem(self) -> str | None:
        """Return why the last message was not sent, once for all messages for which it is so."""
        told, self._told = self._told, self._too_large
        return None if told else self._told


class RosbridgeSubscriptions:
    """All subscriptions of one client.

    Args:
        parts: Carry out the operations.
        principal: The user.
        writer: Writes frames past the queue; None if the connection cannot.
    """

    def __init__(self, parts: Parts, principal: Principal, writer: FrameWriter | None) -> None:
        self._work = parts[Work]
        self._readings = TopicReadings(parts, principal, writer)
        self._outlets: dict[str, TopicOutlet] = {}
        self._changed = asyncio.Event()

    async def subscribe(self, topic: str, type_name: str | None, identity: Identity, request: Subscribe) -> None:
        """Send the messages of a topic.

        Raises:
            GatewayError: As `operations.subscribe`, or the client has too many topics or subscriptions already.
        """
        outlet = self._outlets.get(topic)
        if outlet is None and len(self._outlets) >= MAX_TOPICS:
            raise TooManyRequests(f"this connection already has {MAX_TOPICS} topics")
        known = outlet is not None and identity in outlet.requests
        if not known and sum(len(each.requests) for each in self._outlets.values()) >= MAX_SUBSCRIPTIONS:
            raise TooManyRequests(f"this connection already has {MAX_SUBSCRIPTIONS} subscriptions")
        joined = outlet or TopicOutlet(topic, self._work, self._readings.write, self._changed.set)
        joined.requests[identity] = request
        joined.configure()
        if outlet is None:
            order = ReadTopic(topic, joined, type_name)
            await self._readings.begin(topic, order)
            self._outlets[topic] = joined

    async def unsubscribe(self, topic: str, identity: Identity) -> None:
        """End a subscription; without an id, all of the topic."""
        if (outlet := self._outlets.get(topic)) is None:
            return
        if identity is None:
            outlet.requests.clear()
        else:
            outlet.requests.pop(identity, None)
        if outlet.requests:
            outlet.configure()
        else:
            del self._outlets[topic]
            await self._readings.end(topic)

    async def send_all(
        self, send: Callable[[Payload, int | None], Awaitable[None]], report: Callable[[str], Awaitable[None]]
    ) -> None:
        """Send what waits, when it is due and in pieces of its size, for as long as the client is connected.

        Args:
            send: Sends a message, in pieces of a size.
            report: Tells the client what is not sent, and why.
        """
        while True:
            due = min((outlet.due for outlet in self._outlets.values()), default=NEVER)
            try:
                async with asyncio.timeout_at(None if due == NEVER else due):
                    await self._changed.wait()
            except TimeoutError:
                pass
            self._changed.clear()
            for outlet in list(self._outlets.values()):
                if outlet.due <= _now():
                    await outlet.send_next(send)
                if (problem := outlet.problem()) is not None:
                    await report(f"{outlet.topic}: {problem}")

    async def close(self) -> None:
        """End all subscriptions."""
        for topic in list(self._outlets):
            await self.unsubscribe(topic, None)


def _now() -> float:
    return asyncio.get_running_loop().time()
