"""The current state that a new reader of a stream gets first."""

from typing import Protocol

from dock_gateway.core.event import Event
from dock_gateway.core.filters import EventFilter


class CurrentState(Protocol):
    """The present state, as a reader's event filter covers it."""

    async def snapshot(self, event_filter: EventFilter, position: str) -> Event:
        """Return the first message of a reader who knows nothing yet; `position` is the last event that it includes.

        Its `ends_goal` says whether the reader wants a single goal, which has ended.
        """

    def events(self, event_filter: EventFilter) -> list[Event]:
        """Return the current state as events, for a reader who resumes: events without an id are not replayed."""
