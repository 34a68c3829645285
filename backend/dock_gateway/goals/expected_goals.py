"""Goals that were running when the gateway ended, until their action appears."""

from collections.abc import Iterator

from dock_gateway.core.goal import Goal


class ExpectedGoals:
    """Goals of actions that are not on the ROS graph, each once."""

    def __init__(self) -> None:
        self._goals: dict[str, dict[str, Goal]] = {}  # by action and id

    def add(self, goal: Goal) -> None:
        """Expect a goal until its action appears."""
        self._goals.setdefault(goal.action_name, {})[goal.goal_id] = goal

    def take(self, action: str) -> list[Goal]:
        """Return the goals of an action that has appeared, and expect them no longer."""
        return list(self._goals.pop(action, {}).values())

    def __iter__(self) -> Iterator[Goal]:
        return (goal for goals in self._goals.values() for goal in goals.values())

    def __bool__(self) -> bool:
        return bool(self._goals)
