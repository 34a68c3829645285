"""The order of publication: events wait for one that is being stored, or until they are allowed."""

import time
from collections import OrderedDict, deque
from collections.abc import Callable, Iterable

from dock_gateway.core.event import Event, EventClock, is_end, restamped
from dock_gateway.core.listeners import Listeners

# Seconds after which it is asked again what may be published, while there is something to publish.
WANT_AFTER = 0.1
MAX_OVER = 10_000  # Goals whose published end is remembered.
MAX_STORED = 50_000  # Published states of goals that are remembered.


class Reservation:
    """A place in the order of publication for events that are being stored. Later events wait behind it.

    Attributes:
        stamp: The stamp of its events, in nanoseconds.
        events: The events to publish here; None until they are known.
    """

    def __init__(self, line: "Line", stamp: int) -> None:
        self.stamp = stamp
        self.events: Iterable[Event] | None = None
        self._line = line

    def release(self, events: Iterable[Event] = ()) -> None:
        """Publish these events, and those that waited behind them."""
        self.events = events
        self._line.advance()


class Line:
    """Events in the order of their ids, until they may be published.

    Where gateways share a database, an event waits until its id is *allowed* (`allow`), and the states and results of
    goals come with that permission: all gateways publish them at the same place among their other events. Otherwise
    everything is allowed, and an event waits only behind a `Reservation`.

    Args:
        clock: Stamps the events.
        deliver: Sends an event to those who read.

    Attributes:
        on_want: Called when `allow` should be called again soon.
    """

    def __init__(self, clock: EventClock, deliver: Callable[[Event], None]) -> None:
        self.on_want = Listeners[[]]("permission to publish is wanted")
        self._clock = clock
        self._deliver = deliver
        self._waiting: deque[Event | Reservation] = deque()
        self._allowed: str | None = None  # the id up to which events may be published; None: all
        self._allowed_at = 0.0
        self._stored: OrderedDict[str | None, None] = OrderedDict()  # keys of the events that came stored
        self._over: OrderedDict[str | None, None] = OrderedDict()  # ids of goals whose end is published

    def __len__(self) -> int:
        return len(self._waiting)

    def put(self, event: Event) -> None:
        """Publish an event that has an id as soon as it may be; never, if its goal is over."""
        if event.goal_id is not None and event.goal_id in self._over:
            return
        if self._waiting or not self._may(event):
            self._waiting.append(event)
            self.on_want()
            return
        if self._allowed is not None and time.monotonic() - self._allowed_at > WANT_AFTER:
            self.on_want()
        self._deliver(event)

    def reserve(self, source_ns: int) -> Reservation:
        """Reserve a place for events that must be stored before they are published. Release it soon."""
        place = Reservation(self, self._clock.stamp(source_ns))
        self._waiting.append(place)
        return place

    def advance(self) -> None:
        """Publish all events that no longer have to wait."""
        while self._waiting:
            head = self._waiting[0]
            if isinstance(head, Event):
                if not self._may(head):
                    return
                self._deliver(head)
            elif head.events is None:
                return
            else:
                for event in head.events:
                    self._deliver(event)
            self._waiting.popleft()

    def _may(self, event: Event) -> bool:
        return self._allowed is None or (event.id or "") <= self._allowed

    # ------------------------------------------------------------------ with other gateways

    def allow(self, stored: Iterable[Event], until: str | None) -> None:
        """Publish states and results of goals, and the events that are allowed now.

        Args:
            stored: Events of any gateway, as they are stored.
            until: Events with an id up to this are allowed; None: all are.
        """
        self._insert(stored)
        self._allowed, self._allowed_at = until, time.monotonic()
        self.advance()

    def publish_stored(self, events: Iterable[Event], stored: list[Event] | None) -> list[Event]:
        """Publish events of a goal, unless they came with `allow`; return them as they are published.

        Args:
            events: The events.
            stored: The events as they are stored; None if they are not, as the database takes too long.
        """
        if stored is None:
            stamp = self._clock.stamp(time.time_ns())
            stored = [restamped(event, stamp) for event in events]
        self._insert(stored)
        self.advance()
        if self._waiting:
            self.on_want()
        return stored

    def _insert(self, stored: Iterable[Event]) -> None:
        """Put stored events at their place, each once. Nothing is published about a goal after its end."""
        new = []
        for event in stored:
            if event.key in self._stored or (event.goal_id in self._over and not is_end(event)):
                continue
            new.append(event)
            self._stored[event.key] = None
            if is_end(event):
                self._over[event.goal_id] = None
            self._clock.pass_by(event.id or "")
        while len(self._over) > MAX_OVER:
            self._over.popitem(last=False)
        while len(self._stored) > MAX_STORED:
            self._stored.popitem(last=False)
        if new:
            waiting = [event for event in self._waiting if isinstance(event, Event)]  # there is no `Reservation`
            waiting.extend(new)
            waiting.sort(key=lambda event: event.id or "")
            self._waiting = deque(waiting)
