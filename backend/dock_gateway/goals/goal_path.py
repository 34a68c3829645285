"""The paths of the API that have goals below them: which goals these are."""

from dataclasses import dataclass
from typing import Self

from dock_gateway.core.errors import NotFound
from dock_gateway.core.goal import Goal, Verb


@dataclass(frozen=True)
class GoalPath:
    """A path that has goals below it. Every operation below a path judges the goal by that path.

    Attributes:
        path: The path. A goal is at this path followed by its id.
        verb: What the goals do with their robot, if the path says that.
        action: Absolute name of their action, if the path says that.
    """

    path: str
    verb: Verb | None = None
    action: str | None = None

    @classmethod
    def of_verb(cls, verb: Verb) -> Self:
        """Return `/dock` or `/undock`."""
        return cls(f"/{verb}", verb=verb)

    @classmethod
    def of_action(cls, name: str) -> Self:
        """Return the path of the goals of an action, from its name as it is in the path."""
        return cls(f"/actions/{name}/goals", action=f"/{name}")

    @classmethod
    def of_all(cls) -> Self:
        """Return the path of the goals of all actions."""
        return cls("/goals")

    def require(self, goal: Goal) -> None:
        """Refuse a goal that is not below this path.

        Raises:
            NotFound: `goal_not_found`.
        """
        if self.verb not in {None, goal.verb} or self.action not in {None, goal.action_name}:
            detail = f"goal {goal.goal_id} is on {goal.action_name}: see /goals/{goal.goal_id}"
            raise NotFound(detail, code="goal_not_found")
