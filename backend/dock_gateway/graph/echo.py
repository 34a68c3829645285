"""A watched topic: one subscription for all viewers, decoded at the rate of the fastest viewer."""

import asyncio
import logging
import time
from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

from dock_gateway.core.errors import GatewayError, NotFound
from dock_gateway.core.event import Event, moment, notice, utc_now
from dock_gateway.core.goal import fragment
from dock_gateway.core.graph import Endpoint, Topic
from dock_gateway.core.hub import Subscriber
from dock_gateway.core.tasks import cancel
from dock_gateway.graph.cache import GraphCache
from dock_gateway.ros.bridge import Bridge
from dock_gateway.ros.raw_port import EchoPort, EchoType, Heard, Reading

log = logging.getLogger(__name__)

# Seconds between two rate events and two checks of the topic. A rate is the average of the last WINDOW seconds.
TICK = 1.0
WINDOW = 3
# After a message is decoded, its topic rests for this many times the decoding time, for the sake of other work.
REST = 20


@dataclass(eq=False)
class Viewer:
    """One viewer of a topic.

    Attributes:
        subscriber: Receives messages.
        period: Minimum seconds between two messages.
        due: When the next message may be sent, on the monotonic clock.
        seen: Number of messages received on the topic when the last one was sent.
    """

    subscriber: Subscriber
    period: float
    due: float = 0.0
    seen: int = 0


@dataclass(frozen=True)
class Listening:
    """The type and quality of service of a subscription."""

    kind: str
    reliable: bool
    latched: bool


class Echo:
    """One topic, for all its viewers.

    Args:
        bridge: Runs calls on the ROS thread.
        graph: Knows the endpoints of the topic.
        topic: The current state of the topic.
        tick: See `TICK`.
    """

    def __init__(self, bridge: Bridge, graph: GraphCache, topic: Topic, tick: float = TICK) -> None:
        self._tick = tick
        self._bridge = bridge
        self._graph = graph
        self._topic = topic
        self._viewers: set[Viewer] = set()
        self._listening: Listening | None = None
        self._kind: EchoType | None = None
        self._unreadable: str | None = None
        self._port: EchoPort | None = None
        self._past: deque[tuple[float, Heard]] = deque([(time.monotonic(), Heard())], maxlen=WINDOW + 1)
        self._changed = asyncio.Event()
        self._task: asyncio.Task[None] | None = None

    async def open(self) -> None:
        """Subscribe to the topic.

        Raises:
            Unavailable: `ros_unavailable`, when the ROS thread is down.
        """
        await self._listen(listening_for(self._topic, None))
        self._task = asyncio.create_task(self._run())

    async def close(self) -> None:
        """End the subscription."""
        if self._task is not None:
            await cancel(self._task)
        if self._port is not None:
            self._bridge.to_ros(self._port.close)

    def add(self, viewer: Viewer) -> None:
        """Add a viewer. It gets the topic's state, the newest message, and later ones."""
        self._viewers.add(viewer)
        viewer.subscriber.put(self._topic_event())
        self._changed.set()

    def remove(self, viewer: Viewer) -> None:
        """Remove a viewer."""
        self._viewers.discard(viewer)

    @property
    def viewed(self) -> bool:
        """Whether the topic has viewers."""
        return bool(self._viewers)

    @property
    def _heard(self) -> Heard:
        return Heard() if self._port is None else self._port.heard

    async def _run(self) -> None:
        tick = time.monotonic() + self._tick
        while True:
            try:
                await self._wait(min(tick, self._next_due()))
                await self._show()
                if time.monotonic() >= tick:
                    tick = time.monotonic() + self._tick
                    self._tell_rate()
                    await self._look_again()
            except GatewayError as error:
                log.warning("cannot subscribe to %s: %s", self._topic.name, error.detail)
            except Exception:
                log.exception("while reading %s", self._topic.name)
                await asyncio.sleep(self._tick)

    async def _wait(self, until: float) -> None:
        try:
            async with asyncio.timeout(max(0.0, until - time.monotonic())):
                await self._changed.wait()
        except TimeoutError:
            pass
        self._changed.clear()

    def _waiting(self) -> list[Viewer]:
        heard = self._heard
        if heard.newest is None or self._kind is None or not self._kind.installed:
            return []
        return [viewer for viewer in self._viewers if viewer.seen < heard.messages]

    def _next_due(self) -> float:
        if not self._waiting() and self._port is not None:
            self._port.tell_next()  # a message that arrives right now wakes us, or is seen in the next line
        return min((viewer.due for viewer in self._waiting()), default=float("inf"))

    async def _show(self) -> None:
        began, heard = time.monotonic(), self._heard
        due = [viewer for viewer in self._waiting() if viewer.due <= began]
        if not due or heard.newest is None or self._kind is None:
            return
        reading = await self._read(self._kind, heard.newest)
        if reading is not None:
            event = _event(
                "message",
                self._topic.name,
                time=moment(heard.stamp_ns),
                message=fragment(reading.message),
                abbreviated=bool(reading.lengths),
                lengths=reading.lengths,
            )
            self._send(due, event)
        rest = 0.0 if reading is None else REST * reading.took
        for viewer in due:
            viewer.seen, viewer.due = heard.messages, began + max(viewer.period, rest)

    async def _read(self, kind: EchoType, message: bytes) -> Reading | None:
        before, self._unreadable = self._unreadable, None
        reading: Reading | None = None
        try:
            reading = await asyncio.to_thread(kind.read, message)
        except Exception as error:  # noqa: BLE001 - whatever the bytes of others bring about
            self._unreadable = f"its messages cannot be read as {kind.name}: {error}"
            if before is None:
                log.warning("%s: %s", self._topic.name, self._unreadable)
        if self._unreadable != before:
            self._send(self._viewers, self._topic_event())
        return reading

    def _tell_rate(self) -> None:
        if self._kind is None or not self._kind.installed:  # nothing is received
            return
        now, heard = time.monotonic(), self._heard
        self._past.append((now, heard._replace(newest=None)))
        then, before = self._past[0]
        event = _event(
            "rate",
            self._topic.name,
            hz=round((heard.messages - before.messages) / (now - then), 2),
            bytes_per_s=round((heard.size - before.size) / (now - then)),
            messages=heard.messages,
        )
        self._send(self._viewers, event)

    async def _look_again(self) -> None:
        try:
            topic = await self._graph.topic(self._topic.name)
        except NotFound:  # it may come back
            topic = Topic(self._topic.name, [], [])
        same = topic.document() == self._topic.document()
        self._topic = topic
        listening = listening_for(topic, self._listening)
        if listening != self._listening:
            await self._listen(listening)
        elif same:
            return
        self._send(self._viewers, self._topic_event())

    async def _listen(self, listening: Listening) -> None:
        if self._kind is None or self._kind.name != listening.kind:
            self._kind = await asyncio.to_thread(EchoType, listening.kind)
            self._unreadable = None
        kind, before = self._kind, self._port

        def change() -> EchoPort:
            if before is not None:
                before.close()
            return EchoPort(
                self._bridge,
                self._topic.name,
                kind,
                reliable=listening.reliable,
                latched=listening.latched,
                on_news=self._changed.set,
                heard=self._heard,
            )

        self._port, self._listening = await self._bridge.call(change, undo=EchoPort.close), listening

    def _topic_event(self) -> Event:
        kind = self._kind
        return _event(
            "topic",
            self._topic.document(),
            message_type=kind and kind.name,
            installed=kind is not None and kind.installed,
            hint=self._unreadable or (kind and kind.hint),
        )

    @staticmethod
    def _send(viewers: Iterable[Viewer], event: Event) -> None:
        for viewer in viewers:
            viewer.subscriber.put(event)


def listening_for(topic: Topic, now: Listening | None) -> Listening:
    """Return how to subscribe to every publisher of a topic, and to earlier messages if all publishers keep them.

    If a topic has more than one type, which is a mistake on the graph, one of its publishers' types is used.

    Args:
        topic: The current state of the topic.
        now: The current subscription; it is kept while there are no publishers.
    """
    publishers = topic.publishers
    if not publishers and now is not None:
        return now
    types = sorted({endpoint.type for endpoint in publishers}) or topic.types

    def all_are(name: str, value: str) -> bool:
        return bool(publishers) and all(_quality(endpoint, name) == value for endpoint in publishers)

    return Listening(types[0], all_are("reliability", "reliable"), all_are("durability", "transient_local"))


def _quality(endpoint: Endpoint, name: str) -> str:
    value: str = getattr(endpoint.qos, name)
    return value


def _event(kind: str, topic: Any, **payload: Any) -> Event:
    """Return an event of an echo. It replaces a queued one of the same kind."""
    now = payload.pop("time", None) or utc_now()
    return replace(notice(kind, now, topic=topic, **payload), topic=kind, droppable=True, supersedes=True)
