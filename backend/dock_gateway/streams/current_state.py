"""The current state that a new reader of a stream gets first."""

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

from dock_gateway.core.event import Event, notice, utc_now
from dock_gateway.core.filters import EventFilter
from dock_gateway.core.goal import Goal


def snapshot_of(goals: Sequence[Goal], states: Mapping[str, Any], event_filter: EventFilter, position: str) -> Event:
    """Return the snapshot with these goals and states; `position` as for `notice`."""
    return notice(
        "snapshot",
        utc_now(),
        position=position,
        ends_goal=event_filter.goal_id is not None and all(goal.status.terminal for goal in goals),
        goals=[goal.document() for goal in goals],
        **states,
    )


class CurrentState(Protocol):
    """The present state, as a reader's event filter covers it."""

    async def snapshot(self, event_filter: EventFilter, position: str) -> Event:
        """Return the first message of a reader who knows nothing yet; `position` is the last event that it includes.

        Its `ends_goal` says whether the reader wants a single goal, which has ended.
        """

    def events(self, event_filter: EventFilter) -> list[Event]:
        """Return the current state as events, for a reader who resumes: events without an id are not replayed."""
