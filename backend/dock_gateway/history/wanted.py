"""Which goals somebody asks for. Plain data."""

from dataclasses import dataclass
from datetime import datetime
from functools import cached_property

from dock_gateway.goals import Goal, GoalStatus, Origin
from dock_gateway.namespaces import prefix_of


@dataclass(frozen=True)
class Wanted:
    """Which goals somebody asks for: those that meet all of it.

    Attributes:
        action_names: On one of these actions; none means any.
        namespace: On actions in this namespace or below.
        statuses: In one of these states; none means any.
        origin: Sent by a gateway, or by someone else.
        since: Created at this time or later.
        until: Created before this time.
    """

    action_names: frozenset[str] = frozenset()
    namespace: str = "/"
    statuses: frozenset[GoalStatus] = frozenset()
    origin: Origin | None = None
    since: datetime | None = None
    until: datetime | None = None

    @cached_property
    def prefix(self) -> str:
        """What the names of the actions in the namespace begin with."""
        return prefix_of(self.namespace)

    def matches(self, goal: Goal) -> bool:
        """Whether a goal is one of them."""
        return (
            (not self.action_names or goal.action_name in self.action_names)
            and goal.action_name.startswith(self.prefix)
            and (not self.statuses or goal.status in self.statuses)
            and self.origin in (None, goal.origin)
            and (self.since is None or goal.created_at >= self.since)
            and (self.until is None or goal.created_at < self.until)
        )
