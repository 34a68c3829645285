"""What a subscriber wants to hear of. Plain data."""

from dataclasses import dataclass
from functools import cached_property

from dock_gateway.events import Event
from dock_gateway.namespaces import prefix_of


@dataclass(frozen=True)
class Interest:
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
class WithoutFeedback(Interest):
    """The same, but for the feedback of goals: how they stand and how they end."""

    def covers(self, event: Event) -> bool:
        """Whether an event is of interest."""
        return not (event.droppable and event.topic == "goals") and super().covers(event)
