"""A watched topic: one subscription for all viewers, decoded at the rate of the fastest viewer."""

import asyncio
import logging
import time
from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

from dock_gateway.core.errors import GatewayError
from dock_gateway.core.event import Event, moment, notice, utc_now
from dock_gateway.core.fanout import Subscriber
from dock_gateway.core.goal import fragment
from dock_gateway.core.graph import Topic
from dock_gateway.core.tasks import cancel
from dock_gateway.core.work import Work
from dock_gateway.graph.cache import GraphCache
from dock_gateway.graph.subscription import TopicSubscription, listening_for
from dock_gateway.ros.bridge import Bridge
from dock_gateway.ros.raw_port import EchoType, Heard, Reading, read_message

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


class Echo:
    """One topic, for all its viewers.

    Args:
        bridge: Runs calls on the ROS thread.
        graph: Knows the endpoints of the topic.
        topic: The current state of the topic.
        work: Decodes messages.
        tick: See `TICK`.
    """

    def __init__(self, bridge: Bridge, graph: GraphCache, topic: Topic, work: Work, tick: float = TICK) -> None:
        self._tick = tick
        self._work = work
        self._subscription = TopicSubscription(bridge, graph, topic)
        self._viewers: set[Viewer] = set()
        self._unreadable: str | None = None
        self._past: deque[tuple[float, Heard]] = deque([(time.monotonic(), Heard())], maxlen=WINDOW + 1)
        self._task: asyncio.Task[None] | None = None

    async def open(self) -> None:
        """Subscribe to the topic.

        Raises:
            Unavailable: `ros_unavailable`, when the ROS thread is down.
        """
        await self._subscription.listen(listening_for(self._subscription.topic, None))
        self._task = asyncio.create_task(self._run())

    async def close(self) -> None:
        """End the subscription."""
        if self._task is not None:
            await cancel(self._task)
        self._subscription.close()

    def add(self, viewer: Viewer) -> None:
        """Add a viewer. It gets the topic's state, the newest message, and later ones."""
        self._viewers.add(viewer)
        viewer.subscriber.put(self._topic_event())
        self._subscription.news.set()

    def remove(self, viewer: Viewer) -> None:
        """Remove a viewer."""
        self._viewers.discard(viewer)

    @property
    def viewed(self) -> bool:
        """Whether the topic has viewers."""
        return bool(self._viewers)

    async def _run(self) -> None:
        tick = time.monotonic() + self._tick
        while True:
            try:
                await self._subscription.wait(min(tick, self._next_due()) - time.monotonic())
                await self._show()
                if time.monotonic() >= tick:
                    tick = time.monotonic() + self._tick
                    self._tell_rate()
                    await self._look_again()
            except GatewayError as error:
                log.warning("cannot subscribe to %s: %s", self._subscription.topic.name, error.detail)
            except Exception:
                log.exception("while reading %s", self._subscription.topic.name)
                await asyncio.sleep(self._tick)

    def _waiting(self) -> list[Viewer]:
        heard = self._subscription.heard
        if heard.newest is None or self._subscription.kind is None or not self._subscription.kind.installed:
            return []
        return [viewer for viewer in self._viewers if viewer.seen < heard.messages]

    def _next_due(self) -> float:
        port = self._subscription.port
        if not self._waiting() and port is not None:
            port.tell_next()  # a message that arrives right now wakes us, or is seen in the next line
        return min((viewer.due for viewer in self._waiting()), default=float("inf"))

    async def _show(self) -> None:
        began, heard = time.monotonic(), self._subscription.heard
        due = [viewer for viewer in self._waiting() if viewer.due <= began]
        if not due or heard.newest is None or self._subscription.kind is None:
            return
        reading = await self._read(self._subscription.kind, heard.newest)
        if reading is not None:
            event = _event(
                "message",
                self._subscription.topic.name,
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
            reading = await self._work(len(message), read_message, kind.name, message)
        except Exception as error:  # noqa: BLE001 - whatever the bytes of others bring about
            self._unreadable = f"its messages cannot be read as {kind.name}: {error}"
            if before is None:
                log.warning("%s: %s", self._subscription.topic.name, self._unreadable)
        if self._unreadable != before:
            self._send(self._viewers, self._topic_event())
        return reading

    def _tell_rate(self) -> None:
        if self._subscription.kind is None or not self._subscription.kind.installed:  # nothing is received
            return
        now, heard = time.monotonic(), self._subscription.heard
        self._past.append((now, heard._replace(newest=None)))
        then, before = self._past[0]
        event = _event(
            "rate",
            self._subscription.topic.name,
            hz=round((heard.messages - before.messages) / (now - then), 2),
            bytes_per_s=round((heard.size - before.size) / (now - then)),
            messages=heard.messages,
        )
        self._send(self._viewers, event)

    async def _look_again(self) -> None:
        kind = self._subscription.kind
        try:
            changed = await self._subscription.look_again()
        finally:
            if self._subscription.kind is not kind:
                self._unreadable = None
        if changed:
            self._send(self._viewers, self._topic_event())

    def _topic_event(self) -> Event:
        kind = self._subscription.kind
        return _event(
            "topic",
            self._subscription.topic.document(),
            message_type=kind and kind.name,
            installed=kind is not None and kind.installed,
            hint=self._unreadable or (kind and kind.hint),
        )

    @staticmethod
    def _send(viewers: Iterable[Viewer], event: Event) -> None:
        for viewer in viewers:
            viewer.subscriber.put(event)


def _event(kind: str, topic: Any, **payload: Any) -> Event:
    """Return an event of an echo. It replaces a queued one of the same kind."""
    now = payload.pop("time", None) or utc_now()
    return replace(notice(kind, now, topic=topic, **payload), topic=kind, droppable=True, supersedes=True)
