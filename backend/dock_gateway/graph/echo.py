"""The newest messages of a topic for its viewers, decoded at the rate of the fastest viewer."""

import asyncio
import logging
import time
from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

from dock_gateway.core.event import Event, moment, notice, utc_now
from dock_gateway.core.fanout import Subscriber
from dock_gateway.core.goal import fragment
from dock_gateway.core.tasks import cancel
from dock_gateway.core.work import Work
from dock_gateway.graph.subscription import TopicSubscription, wait
from dock_gateway.ros.raw_port import DecodedMessage, EchoType, Heard, read_message

log = logging.getLogger(__name__)

# Seconds between two rate events. A rate is the average of the last WINDOW seconds.
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
    """The viewers of one topic. It runs while there are some.

    Args:
        subscription: The subscription to the topic.
        work: Decodes messages.
        tick: See `TICK`.
    """

    def __init__(self, subscription: TopicSubscription, work: Work, tick: float = TICK) -> None:
        self._tick = tick
        self._work = work
        self._subscription = subscription
        self._viewers: set[Viewer] = set()
        self._news = asyncio.Event()
        self._unreadable: str | None = None
        self._unreadable_kind: EchoType | None = None  # whose messages could not be read
        self._first = 0  # the number of messages that were received before the first viewer came
        self._past: deque[tuple[float, Heard]] = deque(maxlen=WINDOW + 1)
        self._task: asyncio.Task[None] | None = None

    def add(self, viewer: Viewer) -> None:
        """Add a viewer. It gets the topic's state, the newest message, and later ones."""
        self._viewers.add(viewer)
        viewer.subscriber.put(self._topic_event())
        if self._task is None:
            heard = self._subscription.heard
            self._first = heard.messages
            self._past.clear()
            self._past.append((time.monotonic(), heard._replace(newest=None)))
            self._task = asyncio.create_task(self._run())
        self._news.set()

    def remove(self, viewer: Viewer) -> None:
        """Remove a viewer."""
        self._viewers.discard(viewer)
        if not self._viewers and self._task is not None:
            self._task.cancel()
            self._task = None

    async def close(self) -> None:
        """Show no more messages."""
        if self._task is not None:
            await cancel(self._task)

    @property
    def viewed(self) -> bool:
        """Whether the topic has viewers."""
        return bool(self._viewers)

    def changed(self) -> None:
        """Show that the topic or the subscription has changed."""
        self._send(self._viewers, self._topic_event())
        self._news.set()

    async def _run(self) -> None:
        tick = time.monotonic() + self._tick
        while True:
            try:
                await wait(self._news, min(tick, self._next_due()) - time.monotonic())
                await self._show()
                if time.monotonic() >= tick:
                    tick = time.monotonic() + self._tick
                    self._tell_rate()
            except Exception:
                log.exception("while reading %s", self._subscription.topic.name)
                await asyncio.sleep(self._tick)

    def _waiting(self) -> list[Viewer]:
        heard = self._subscription.heard
        if heard.newest is None or not self._subscription.is_readable:
            return []
        return [viewer for viewer in self._viewers if viewer.seen < heard.messages]

    def _next_due(self) -> float:
        if not self._waiting():
            self._subscription.tell_next(self._news)  # what arrives right now wakes us, or is seen in the next line
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

    async def _read(self, kind: EchoType, message: bytes) -> DecodedMessage | None:
        before = self._hint_of(kind)
        self._unreadable, self._unreadable_kind = None, kind
        reading: DecodedMessage | None = None
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
        if not self._subscription.is_readable:
            return
        now, heard = time.monotonic(), self._subscription.heard
        self._past.append((now, heard._replace(newest=None)))
        then, before = self._past[0]
        event = _event(
            "rate",
            self._subscription.topic.name,
            rate_hz=round((heard.messages - before.messages) / (now - then), 2),
            bytes_per_s=round((heard.size - before.size) / (now - then)),
            messages=heard.messages - self._first,
        )
        self._send(self._viewers, event)

    def _hint_of(self, kind: EchoType | None) -> str | None:
        """Return why the last message could not be read, if it was of this type."""
        return self._unreadable if kind is self._unreadable_kind else None

    def _topic_event(self) -> Event:
        kind = self._subscription.kind
        return _event(
            "topic",
            self._subscription.topic.document(),
            message_type=kind and kind.name,
            installed=self._subscription.is_readable,
            hint=self._hint_of(kind) or (kind and kind.hint),
        )

    @staticmethod
    def _send(viewers: Iterable[Viewer], event: Event) -> None:
        for viewer in viewers:
            viewer.subscriber.put(event)


def _event(kind: str, topic: Any, **payload: Any) -> Event:
    """Return an event of an echo. It replaces a queued one of the same kind."""
    now = payload.pop("time", None) or utc_now()
    return replace(notice(kind, now, topic=topic, **payload), topic=kind, droppable=True, supersedes=True)
