"""What a subscriber wants to hear of. Plain data."""

from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime
from functools import cached_property

from dock_gateway.core.event import Event
from dock_gateway.core.goal import Goal, GoalStatus, Origin


def prefix_of(namespace: str) -> str:
    """What the names in a namespace begin with."""
    return f"{namespace.rstrip('/')}/"


def is_under(name: str, namespace: str) -> bool:
    """Whether a namespace or an action is a namespace, or in it."""
    return prefix_of(name).startswith(prefix_of(namespace))


def lineage(name: str) -> Iterator[str]:
    """The namespaces that a name is in, from the root on, and the name itself: `/`, `/fleet`, `/fleet/robot1`."""
    yield "/"
    for end, character in enumerate(name[1:], 1):
        if character == "/":
            yield name[:end]
    if name != "/":
        yield name


@dataclass(frozen=True)
class EventFilter:
    """What a subscriber wants to hear of.

    Attributes:
        topics: `goals`, `battery`, `cmd_vel`, `system`, `scene`, `robots`.
        goal_id: Only events of this goal.
        action_name: Only goals and servers of this action.
        namespace: Only goals and servers of actions in this namespace or below.
        robot: The namespace whose battery, velocity and scene are meant.
    """

    topics: frozenset[str] = frozenset({"goals"})
    goal_id: str | None = None
    action_name: str | None = None
    namespace: str = "/"
    robot: str = "/"

    def covers(self, event: Event) -> bool:
        """Whether an event is of interest."""
        if event.topic not in self.topics:
            return False
        if event.robot is not None:
            return event.robot == self.robot
        if event.action_name is None:
            return True  # it is about all robots
        return self.covers_goal(event.goal_id, event.action_name)

    def covers_goal(self, goal_id: str | None, action_name: str) -> bool:
        """Whether a goal is of interest, or, without a goal id, an action."""
        return (
            (goal_id is None or self.goal_id in (None, goal_id))
            and self.action_name in (None, action_name)
            and action_name.startswith(self._prefix)
        )

    @cached_property
    def _prefix(self) -> str:
        return prefix_of(self.namespace)


@dataclass(frozen=True)
class WithoutFeedback(EventFilter):
    """The same, but for the feedback of goals: how they stand and how they end."""

    def covers(self, event: Event) -> bool:
        """Whether an event is of interest."""
        return not (event.droppable and event.topic == "goals") and super().covers(event)


@dataclass(frozen=True)
class GoalFilter:
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
