"""`?max_rate=`: a reader that wants fewer messages gets the newest of each kind, so often and no more. Pure."""

from collections.abc import Iterable

from dock_gateway.core.event import Event

Key = tuple[str, str | None]


class Throttle:
    """Lets through what must arrive at once, and of what may be dropped the newest, `max_rate` times a second.

    Args:
        max_rate: Messages a second of each goal's feedback, of battery and of velocity; None lets all through.
    """

    def __init__(self, max_rate: float | None) -> None:
        self._period = 0.0 if max_rate is None else 1 / max_rate
        self._held: dict[Key, Event] = {}
        self._sent_at: dict[Key, float] = {}

    def let_through(self, events: Iterable[Event], now: float) -> list[Event]:
        """What is to be sent now; `now` in seconds on any clock that does not step back."""
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
        """When there is something to be sent again, on the clock of `let_through`."""
        return min((self._due(key) for key in self._held), default=float("inf"))
