"""Keeps the position up to which the stream of a site has been read."""

from datetime import datetime, timedelta
from typing import Any

from dock_gateway.core.event import CLOCK_TOLERANCE, STATUS, event_id, moment, nanoseconds, stamp_of
from dock_gateway.core.goal import Goal
from dock_gateway.http.queries import EVENT_ID
from dock_hub.fields import ForeignDocumentError
from dock_hub.site_view import SiteView


class Reading:
    """The position up to which a stream of a site has been read.

    Args:
        cursor: The last event that is stored; None if the site was never read.

    Attributes:
        first_robots: Whether the next robots are all of them.
        gap: Whether events are missing that the site no longer has: its goals are read instead.
        newest: Id of the newest event that was read; empty if there is none yet.
    """

    def __init__(self, cursor: str | None) -> None:
        self.first_robots = False
        self.gap = False
        self.newest = ""
        self._since: datetime | None = None if cursor is None else moment(stamp_of(cursor)) - timedelta(seconds=5)
        self._missed = 0

    def begin(self, message: dict[str, Any], view: SiteView) -> None:
        """Note how many missed events follow."""
        count = message.get("count")
        self._missed = count if isinstance(count, int) else 0
        self.first_robots = True
        view.behind = self._missed > 0

    def count_event(self, view: SiteView) -> None:
        """Note that an event was read."""
        if self._missed:
            self._missed -= 1
            view.behind = self._missed > 0

    def tells_of(self, goal: Goal) -> bool:
        """Return whether the end of a goal may not have been published: it is later than what was read before."""
        return self._since is not None and (goal.finished_at or goal.updated_at) >= self._since


def read_event_id(value: object) -> str:
    """Return the id of an event of a site.

    Raises:
        ForeignDocumentError: It is none.
    """
    if not isinstance(value, str) or not EVENT_ID.fullmatch(value):
        raise ForeignDocumentError(f"{value!r:.60} is not the id of an event")
    return value


def id_before(time: datetime) -> str:
    """Return an id to resume from at a site that had no event at that time: all of its events come later."""
    return event_id(nanoseconds(time) - CLOCK_TOLERANCE, STATUS, "none")
