"""The latest robots, alerts and approvals of a site, in memory."""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

import orjson

from dock_hub.fields import ForeignDocumentError

Document = dict[str, Any]

# Robots of a site, and the bytes of all of them, of all alerts and of all approvals. More are not taken over.
MAX_ROBOTS, MAX_BYTES = 2000, 8 * 1024 * 1024


@dataclass
class SiteView:
    """The latest report of a site, with names of the hub.

    Attributes:
        site: The site.
        robots: Its robots, by name.
        alerts: Its alerts.
        approvals: The goals of agents that wait there for a person.
        changed: Names of robots that changed or left since the last publication.
        reported_at: Time of its latest report, on the monotonic clock; None: never.
        round_trip: Seconds that its last small answer took; None: not measured.
        behind: Whether it is still being asked for what the hub has missed.
        cursor: Id of its last event that is stored.
        trouble: Why it cannot be followed, though it is connected; None while it is.
    """

    site: str
    robots: dict[str, Document] = field(default_factory=dict)
    alerts: list[Document] = field(default_factory=list)
    approvals: list[Document] = field(default_factory=list)
    changed: set[str] = field(default_factory=set)
    reported_at: float | None = None
    round_trip: float | None = None
    behind: bool = False
    cursor: str | None = None
    trouble: str | None = None
    malformed: Counter[str] = field(default_factory=Counter)
    _sizes: dict[str, int] = field(default_factory=dict)  # bytes of each robot

    def take_changed(self, most: int) -> list[str]:
        """Return names of robots that changed or left since the last publication, of `most` bytes or a little more.

        The others are returned the next time.
        """
        taken: list[str] = []
        size = 0
        for name in sorted(self.changed):
            if size > most:
                break
            taken.append(name)
            size += self._sizes.get(name, 0)
        self.changed.difference_update(taken)
        return taken

    def put_robots(self, robots: Iterable[Document], gone: Iterable[str] = (), *, all_of_them: bool = False) -> None:
        """Take over robots; those that are gone, or not among all of them, leave.

        Raises:
            ForeignDocumentError: The site would have too many, or too much of them.
        """
        new = {robot["name"]: robot for robot in robots}
        left = self.robots.keys() - new.keys() if all_of_them else self.robots.keys() & set(gone)
        for name in left:
            del self.robots[name]
        if len(self.robots.keys() | new.keys()) > MAX_ROBOTS:
            raise ForeignDocumentError(f"the site has more than {MAX_ROBOTS} robots")
        sizes = {name: size for name, size in self._sizes.items() if name in self.robots}
        sizes |= {name: _size(robot) for name, robot in new.items()}
        _require_room("robots", sum(sizes.values()))
        self._sizes = sizes
        self.robots |= new
        self.changed |= left | new.keys()

    def put_alerts(self, alerts: list[Document]) -> None:
        """Take over all alerts.

        Raises:
            ForeignDocumentError: They are too much.
        """
        _require_room("alerts", _size(alerts))
        self.alerts = alerts

    def put_approvals(self, approvals: list[Document]) -> None:
        """Take over all approvals.

        Raises:
            ForeignDocumentError: They are too much.
        """
        _require_room("approvals", _size(approvals))
        self.approvals = approvals

    def touch(self) -> None:
        """Publish all robots again: the state of the site has changed."""
        self.changed |= self.robots.keys()

    def goals_running(self) -> int:
        """Return the number of goals that run on its robots."""
        return sum(len(robot["goals"]) for robot in self.robots.values())

    def stopped(self) -> list[str]:
        """Return the names of the robots that a stop holds."""
        return sorted(name for name, robot in self.robots.items() if robot["stop"]["latched"])


def _size(document: object) -> int:
    return len(orjson.dumps(document))


def _require_room(what: str, size: int) -> None:
    if size > MAX_BYTES:
        raise ForeignDocumentError(f"the {what} of the site have {size} bytes, and at most {MAX_BYTES} are shown")
