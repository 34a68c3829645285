"""Which robot an action belongs to, and which actions a list of goals is about."""

from collections.abc import Callable, Iterable

from dock_gateway.core.filters import lineage, parent_of
from dock_gateway.core.grant import Grant
from dock_gateway.core.namespace import read_namespace
from dock_gateway.goals.docking_actions import DockingActions
from dock_gateway.robots.robots import RobotLabels, Robots
from dock_gateway.storage import History


class Owners:
    """Knows the robots of actions, also of those that have left the graph.

    Args:
        docking: Which actions dock and undock robots.
        robots: The robots that are known now.
        labels: Say which robots there are besides, and their groups.
        history: Knows all actions that have had goals.
    """

    def __init__(self, docking: DockingActions, robots: Robots, labels: RobotLabels, history: History) -> None:
        self._docking = docking
        self._robots = robots
        self._labels = labels
        self._history = history

    def among(self, action_names: Iterable[str]) -> Callable[[str], str]:
        """Return a function that names the robot of an action: the one with the longest namespace containing it.

        A namespace with a label or with goals of a docking action is a robot, too, even if it is not on the graph now.
        """
        docking = self._docking
        gone = {
            namespace
            for name in action_names
            if docking.catalog.may_be_robot(namespace := parent_of(name)) and name in docking.all_names(namespace)
        }
        robots = gone.union(self._labels.robots(), self._robots.namespaces())

        def owner(action_name: str) -> str:
            namespace = parent_of(docking.catalog.place_of(action_name))
            return next((each for each in reversed([*lineage(namespace)]) if each in robots), namespace)

        return owner

    def docks(self, robot: str) -> frozenset[str]:
        """Return the names of all actions that dock a robot or may have done so."""
        return self._docking.all_names(robot, "dock")

    async def choose_actions(self, grant: Grant, group: str | None) -> frozenset[str] | None:
        """Return the actions that a grant covers, and whose robots are in a group now; None if that is every action.

        Raises:
            Unavailable: The history does not answer (`history_unavailable`).
        """
        if group is None and not (grant.limited or grant.share):
            return None
        names = await self._history.action_names()
        chosen = frozenset(filter(grant.covers_action, names))
        if group is None:
            return chosen
        members, owner = self._labels.in_group(group), self.among(names)
        return frozenset(name for name in chosen if owner(name) in members)

    def homed_in(self, robot: str | None) -> frozenset[str]:
        """Return the actions elsewhere that belong to robots in a namespace; without one, all actions are meant anyway.

        Raises:
            InvalidField: The namespace is not valid.
        """
        return frozenset() if robot is None else self._docking.catalog.homed_in(read_namespace(robot))
