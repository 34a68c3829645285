"""Fan-out: every event goes to every subscriber that wants it. A slow subscriber affects only itself."""

import asyncio
import itertools
import time
from collections import Counter, defaultdict, deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from operator import attrgetter
from typing import Protocol

from dock_gateway.core.errors import Unavailable
from dock_gateway.core.event import POSITION, STATUS, Event, EventClock, event_id, position_of
from dock_gateway.core.event_buffer import EventBuffer
from dock_gateway.core.filters import EventFilter
from dock_gateway.core.line import Line
from dock_gateway.core.listeners import Listeners
from dock_gateway.core.narrowing import narrow


class FrameWriter(Protocol):
    """Writes to one connection past its queue."""

    def write_frame(self, frame: bytes) -> bool:
        """Write a whole frame now. Return False, without writing, if it would have to wait."""


@dataclass(slots=True)
class Queued:
    """An event in a reader's queue, with its place in the order."""

    number: int
    event: Event


class Subscriber:
    """One reader's queue. What an event costs does not depend on how many wait: a slow reader slows no other.

    Feedback beyond `limit` events is dropped, oldest first, and counted. Events that must not be lost (status, result)
    are kept up to a hard limit. Beyond it the reader is `overrun` and must be disconnected.

    Attributes:
        overrun: Whether too many events wait; the reader must be disconnected.
        expelled: Whether the reader may no longer read; it must be disconnected.
        writer: Writes an event's frame past the queue and its task, if the connection can. Used only while that task
            waits and the queue is empty, so the order is kept.
        after: Id of the last event that the reader received, at any gateway. Events up to it are not queued.
        dropped: Number of events dropped since the reader came.
    """

    HARD_LIMIT = 10_000

    def __init__(self, limit: int, event_filter: EventFilter) -> None:
        self.event_filter = event_filter
        self.overrun = False
        self.expelled = False
        self.writer: FrameWriter | None = None
        self.after = ""
        self.dropped = 0
        self._waiting = False
        self._limit = limit
        self._numbers = itertools.count()
        self._kept: deque[Queued] = deque()
        self._droppable: deque[Queued] = deque()
        self._newest: dict[tuple[str, str | None], Queued] = {}  # of what is superseded, by topic and robot
        self._unreported = 0  # dropped events that the next `take` reports
        self._wake = asyncio.Event()

    def put(self, event: Event) -> None:
        """Send an event immediately if possible, else queue it. Never waits."""
        if event.id is not None and event.id <= self.after:
            return
        grant = self.event_filter.grant
        shown = event if grant is None else narrow(event, grant)
        if shown is None:
            return
        event = shown
        if self._waiting and self.writer is not None and self.empty and self.writer.write_frame(event.frame):
            return
        key = event.topic, event.robot
        if event.supersedes and (queued := self._newest.get(key)) is not None:
            queued.event = event
            return
        queued = Queued(next(self._numbers), event)
        if event.droppable:
            if len(self._droppable) >= self._limit:
                self._drop_oldest()
            self._droppable.append(queued)
        elif len(self._kept) >= self.HARD_LIMIT:
            self.overrun = True
            self._wake.set()
            return
        else:
            self._kept.append(queued)
        if event.supersedes:
            self._newest[key] = queued
        self._wake.set()

    @property
    def empty(self) -> bool:
        """Whether no event waits."""
        return not (self._kept or self._droppable)

    def _drop_oldest(self) -> None:
        event = self._droppable.popleft().event
        if event.supersedes:
            del self._newest[event.topic, event.robot]
        self._unreported += 1
        self.dropped += 1

    def expel(self) -> None:
        """End the stream, as its reader may no longer read."""
        self.expelled = True
        self.writer = None
        self._wake.set()

    def wake(self) -> None:
        """Let `take` return, even with nothing queued."""
        self._wake.set()

    def clear(self) -> None:
        """Empty the queue, for a reader that gets a snapshot instead."""
        self._kept.clear()
        self._droppable.clear()
        self._newest.clear()
        self._unreported = 0

    def catch_up(self, event_id: str) -> None:
        """Drop queued events up to this one; the reader gets them another way."""
        self.after = event_id
        for events in (self._kept, self._droppable):
            later = [each for each in events if each.event.id is None or each.event.id > event_id]
            events.clear()
            events.extend(later)
        waiting = (*self._kept, *self._droppable)
        self._newest = {(each.event.topic, each.event.robot): each for each in waiting if each.event.supersedes}

    async def take(self, timeout: float) -> tuple[list[Event], int]:
        """Wait up to `timeout` seconds; return all queued events and the number dropped, `([], 0)` at a timeout."""
        self._waiting = True
        try:
            async with asyncio.timeout(timeout):
                await self._wake.wait()
        except TimeoutError:
            return [], 0
        finally:
            self._waiting = False
        self._wake.clear()
        queued = sorted((*self._kept, *self._droppable), key=attrgetter("number"))
        events, unreported = [each.event for each in queued], self._unreported
        self.clear()
        return events, unreported


class Fanout:
    """All subscribers of this process, and the most recently published events.

    Args:
        queue_limit: Maximum number of feedback events queued for a slow subscriber.
        keep: Called with every event that a reader can resume from, for the history.
        newest: Id of the newest stored event.
        recent: Number of events kept, some seconds of a busy gateway. A reader that was away for longer resumes from
            the history.

    Attributes:
        clock: Stamps the events that are published here.
        line: The order in which events are published that have an id.
        published: Number of events published, by kind: their topic, or `feedback`.
        sent: Number of events handed to subscribers, by kind.
    """

    def __init__(
        self,
        *,
        queue_limit: int,
        keep: Callable[[Event], None] = lambda _: None,
        newest: str = "",
        recent: int = 4_000,
    ) -> None:
        self.clock = EventClock(newest)
        self.line = Line(self.clock, self._deliver)
        self.published: Counter[str] = Counter()
        self.sent: Counter[str] = Counter()
        self._dropped_before = 0  # by subscribers that have left
        self._keep = keep
        self._recent = EventBuffer(recent)
        # Before all events of this process, and whether it still has all of them.
        self._beginning, self._has_all = event_id(self.clock.stamp(time.time_ns()), STATUS, "none"), True
        self._queue_limit = queue_limit
        self._subscribers: set[Subscriber] = set()
        # By topic and robot, and by topic alone: an event of one robot costs nothing for readers of the others.
        self._wanting: defaultdict[tuple[str, str | None], set[Subscriber]] = defaultdict(set)
        self._on_watch: dict[str, Callable[[], None]] = {}
        self.closing = False
        self.on_close = Listeners[[]]("streams are to end")  # may be called twice

    def __len__(self) -> int:
        return len(self._subscribers)

    def subscribe(self, event_filter: EventFilter) -> Subscriber:
        """Add a subscriber. It receives every event published from now on that its filter covers.

        Raises:
            Unavailable: The gateway is shutting down.
        """
        if self.closing:
            raise Unavailable("the gateway is shutting down", code="shutting_down")
        subscriber = Subscriber(self._queue_limit, event_filter)
        self._subscribers.add(subscriber)
        for key in _keys(event_filter):
            self._wanting[key].add(subscriber)
        self._tell_watchers(event_filter)
        return subscriber

    @property
    def dropped(self) -> int:
        """Number of events dropped because a subscriber was slow."""
        return self._dropped_before + sum(subscriber.dropped for subscriber in self._subscribers)

    def unsubscribe(self, subscriber: Subscriber) -> None:
        """Remove a subscriber. Idempotent."""
        if subscriber in self._subscribers:
            self._subscribers.remove(subscriber)
            self._dropped_before += subscriber.dropped
        for key in _keys(subscriber.event_filter):
            self._wanting[key].discard(subscriber)
            if not self._wanting[key]:
                del self._wanting[key]
        self._tell_watchers(subscriber.event_filter)

    def on_watch(self, topic: str, changed: Callable[[], None]) -> None:
        """Register `changed`, to be called whenever a subscriber to a topic comes or goes."""
        self._on_watch[topic] = changed

    def watched(self, topic: str) -> set[str]:
        """Return the robots whose topic has a subscriber."""
        return {robot for wanted, robot in self._wanting if wanted == topic and robot is not None}

    def _tell_watchers(self, event_filter: EventFilter) -> None:
        for topic in event_filter.topics & self._on_watch.keys():
            self._on_watch[topic]()

    def publish(self, event: Event) -> None:
        """Send an event to every subscriber that wants it: now, or after those that it has to wait for."""
        if event.id is None:
            self._deliver(event)
        else:
            self.line.put(event)

    def _deliver(self, event: Event) -> None:
        if event.id is not None and event.topic != "cmd_vel":
            if event.id in self._recent:
                return
            if self._recent.put(event):
                self._has_all = False
            self._keep(event)
        readers = 0
        for subscriber in self._wanting.get((event.topic, event.robot), ()):
            if subscriber.event_filter.covers(event):
                subscriber.put(event)
                readers += 1
        kind = "feedback" if event.droppable and event.topic == "goals" else event.topic
        self.published[kind] += 1
        self.sent[kind] += readers

    @property
    def newest(self) -> str:
        """Id of the last event that was published. Readers get its position instead, which `resolve` knows."""
        return next(reversed(self._recent), self._beginning)

    @property
    def position(self) -> str:
        """The position of the last event that was published, to go on from."""
        return position_of(self.newest)

    def resolve(self, after: str) -> str:
        """Return the id of the event that a reader names, by its id or its position.

        Of a position that this process no longer holds, return what comes right before: its event may come once more.
        """
        found = POSITION.fullmatch(after)
        if found is None:
            return after
        same = (
            each
            for each in (self._beginning, *self._recent)
            if each.startswith(found[1]) and position_of(each) == after
        )
        return next(same, found[1])

    def since(self, after: str, event_filter: EventFilter) -> list[Event] | None:
        """Return the events published after an event, in order; None if that event is not in the buffer."""
        if after not in self._recent and not (after == self._beginning and self._has_all):
            return None
        later = itertools.takewhile(lambda event: event.id != after, reversed(self._recent.values()))
        return [event for event in list(later)[::-1] if event_filter.covers(event)]

    def close(self) -> None:
        """Let every stream send its closing message. New subscribers are refused."""
        self.closing = True
        for subscriber in self._subscribers:
            subscriber.wake()
        self.on_close()


def _keys(event_filter: EventFilter) -> Iterator[tuple[str, str | None]]:
    """Yield the keys of a subscriber. `covers` returns False for events of any other topic and robot."""
    for topic in event_filter.topics:
        yield topic, None
        yield topic, event_filter.robot
