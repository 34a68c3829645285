"""`?max_rate=`: limits the rate of messages to a reader, keeping the newest of each kind. Pure."""

from collections.abc import Iterable

from dock_gateway.core.event import Event

Key = tuple[str, str | None]


class Throttle:
    """Passes undroppable events immediately, and the newest of the droppable ones `max_rate` times a second.

    Args:
        max_rate: Messages per second of each goal's feedback, of battery and of velocity; None means no limit.
    """

    def __init__(self, max_rate: float | None) -> None:
        self._period = 0.0 if max_rate is None else 1 / max_rate
        self._held: dict[Key, Event] = {}
        self._sent_at: dict[Key, float] = {}

    def let_through(self, events: Iterable[Event], now: float) -> list[Event]:
        """Return the events to send now; `now` in seconds on any monotonic clock."""
        if not self._period:
            return list(events)
        passed: list[Event] = []
        for event in events:
            key = (event.topic, event.goal_id or event.robot)
            if event.droppable:
                self._held[key] = event
                continue
            if held := self._held.pop(key, None):  # the last feedback comes before the end
                passed.append(held)
            self._sent_at.pop(key, None)
            passed.append(event)
        for key in [key for key in self._held if self._due(key) <= now]:
            passed.append(self._held.pop(key))
            self._sent_at[key] = now
        return passed

    def _due(self, key: Key) -> float:
        return self._sent_at.get(key, float("-inf")) + self._period

    def next_due(self) -> float:
        """Return when the next held event is due, on the clock of `let_through`; infinite if none is held."""
        return min((self._due(key) for key in self._held), default=float("inf"))
