"""Filters for events and goals. Plain data."""

from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime
from functools import cached_property

from dock_gateway.core.event import Event
from dock_gateway.core.goal import Goal, GoalStatus, Origin, Verb
from dock_gateway.core.grant import Grant


def prefix_of(namespace: str) -> str:
    """Return the prefix of the names in a namespace."""
    return f"{namespace.rstrip('/')}/"


def is_under(name: str, namespace: str) -> bool:
    """Return whether a namespace or an action is `namespace` itself or lies in it."""
    return prefix_of(name).startswith(prefix_of(namespace))


def parent_of(name: str) -> str:
    """Return the namespace that an action is in: `/robot1` of `/robot1/dock`."""
    return name.rpartition("/")[0] or "/"


def is_hidden(name: str, within: str = "/") -> bool:
    """Return whether a name is hidden, as ROS calls it: a part of it begins with `_`.

    Args:
        name: An absolute name.
        within: A namespace whose own parts do not count for the names in it.
    """
    visible = len(within.rstrip("/")) if is_under(name, within) else 0
    return "/_" in name[visible:]


def lineage(name: str) -> Iterator[str]:
    """Yield the namespaces that a name is in, root first, then the name itself: `/`, `/fleet`, `/fleet/robot1`."""
    yield "/"
    for end, character in enumerate(name[1:], 1):
        if character == "/":
            yield name[:end]
    if name != "/":
        yield name


@dataclass(frozen=True)
class EventFilter:
    """The events that a subscriber wants.

    Attributes:
        topics: `goals`, and types of other events.
        goal_id: Only events of this goal.
        action_name: Only goals and servers of this action.
        namespace: Only goals and servers of actions in this namespace or below.
        robot: The namespace of the robot whose battery, velocity and scene are wanted.
        grant: The reader's grant; None means everything.
        homed: Actions elsewhere that belong to robots in the namespace.
    """

    topics: frozenset[str] = frozenset({"goals"})
    goal_id: str | None = None
    action_name: str | None = None
    namespace: str = "/"
    robot: str = "/"
    grant: Grant | None = None
    homed: frozenset[str] = frozenset()

    def covers(self, event: Event) -> bool:
        """Return whether the filter covers an event."""
        if event.topic not in self.topics:
            return False
        if event.robot is not None:
            return event.robot == self.robot
        if event.action_name is None:
            return True  # it is about all robots
        return self.covers_goal(event.goal_id, event.action_name)

    def covers_goal(self, goal_id: str | None, action_name: str) -> bool:
        """Return whether the filter covers a goal or, without a goal id, an action."""
        return (
            (goal_id is None or self.goal_id in (None, goal_id))
            and self.action_name in (None, action_name)
            and (action_name.startswith(self._prefix) or action_name in self.homed)
            and (self.grant is None or self.grant.covers_action(action_name))
        )

    @cached_property
    def _prefix(self) -> str:
        return prefix_of(self.namespace)


@dataclass(frozen=True)
class WithoutFeedback(EventFilter):
    """An `EventFilter` that leaves out the feedback of goals: only their status and result."""

    def covers(self, event: Event) -> bool:
        """Return whether the filter covers an event."""
        return not (event.droppable and event.topic == "goals") and super().covers(event)


@dataclass(frozen=True)
class GoalFilter:
    """A query for goals. A goal must meet all conditions.

    Attributes:
        action_names: On one of these actions; empty means any.
        namespace: On actions in this namespace or below.
        statuses: In one of these states; empty means any.
        error_codes: With one of these error codes; empty means any, also none.
        origin: Sent by a gateway or by another client; None means any.
        verb: That dock or undock a robot; None means any.
        since: Created at this time or later; None means any time.
        until: Created before this time; None means any time.
        id_prefix: With an id that begins with this, in lower case.
        tags: With one of these tags; empty means any, also none.
        group: The group that `among` stands for; None if no group was asked for.
        among: On one of these actions, too; None means any.
        homed: Actions elsewhere that belong to robots in the namespace.
    """

    action_names: frozenset[str] = frozenset()
    namespace: str = "/"
    statuses: frozenset[GoalStatus] = frozenset()
    error_codes: frozenset[str] = frozenset()
    origin: Origin | None = None
    verb: Verb | None = None
    since: datetime | None = None
    until: datetime | None = None
    id_prefix: str = ""
    tags: frozenset[str] = frozenset()
    group: str | None = None
    among: frozenset[str] | None = None
    homed: frozenset[str] = frozenset()

    @cached_property
    def prefix(self) -> str:
        """The prefix of the names of actions in the namespace."""
        return prefix_of(self.namespace)

    def matches(self, goal: Goal) -> bool:
        """Return whether a goal meets all conditions but the tags, which only the history has."""
        return (
            self.includes(goal.action_name)
            and (not self.statuses or goal.status in self.statuses)
            and (not self.error_codes or (goal.error is not None and goal.error.code in self.error_codes))
            and self.origin in (None, goal.origin)
            and self.verb in (None, goal.verb)
            and (self.since is None or goal.created_at >= self.since)
            and (self.until is None or goal.created_at < self.until)
            and goal.goal_id.startswith(self.id_prefix)
        )

    def includes(self, action_name: str) -> bool:
        """Return whether goals on an action can meet the conditions."""
        return (
            (not self.action_names or action_name in self.action_names)
            and (action_name.startswith(self.prefix) or action_name in self.homed)
            and (self.among is None or action_name in self.among)
        )
