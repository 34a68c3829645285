"""What the hub has of a site in memory: its robots, alerts and approvals as it told them last."""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

from dock_gateway.hub.fields import ForeignDocumentError

Document = dict[str, Any]

# Robots of a site. More are not taken over.
MAX_ROBOTS = 2000


@dataclass
class SiteView:
    """The newest that a site has told, with names of the hub.

    Attributes:
        site: The site.
        robots: Its robots, by name.
        alerts: Its alerts.
        approvals: The goals of agents that wait there for a person.
        changed: Names of robots that changed or left since the last publication.
        alerts_changed, approvals_changed: Whether those changed since then.
        reported_at: When it told something last, on the monotonic clock; None: never.
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
    alerts_changed: bool = False
    approvals_changed: bool = False
    reported_at: float | None = None
    round_trip: float | None = None
    behind: bool = False
    cursor: str | None = None
    trouble: str | None = None
    malformed: Counter[str] = field(default_factory=Counter)

    def put_robots(self, robots: Iterable[Document], gone: Iterable[str] = (), *, all_of_them: bool = False) -> None:
        """Take over robots; those that are gone, or not among all of them, leave.

        Raises:
            ForeignDocumentError: The site would have too many.
        """
        new = {robot["name"]: robot for robot in robots}
        left = self.robots.keys() - new.keys() if all_of_them else self.robots.keys() & set(gone)
        for name in left:
            del self.robots[name]
        if len(self.robots.keys() | new.keys()) > MAX_ROBOTS:
            raise ForeignDocumentError(f"the site has more than {MAX_ROBOTS} robots")
        self.robots |= new
        self.changed |= left | new.keys()

    def put_alerts(self, alerts: list[Document]) -> None:
        """Take over all alerts."""
        self.alerts, self.alerts_changed = alerts, True

    def put_approvals(self, approvals: list[Document]) -> None:
        """Take over all approvals."""
        self.approvals, self.approvals_changed = approvals, True

    def touch(self) -> None:
        """Publish all robots again: the state of the site has changed."""
        self.changed |= self.robots.keys()

    def goals_running(self) -> int:
        """Return the number of goals that run on its robots."""
        return sum(len(robot["goals"]) for robot in self.robots.values())

    def stopped(self) -> list[str]:
        """Return the names of the robots that a stop holds."""
        return sorted(name for name, robot in self.robots.items() if robot["stop"]["latched"])
