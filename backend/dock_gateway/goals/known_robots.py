"""Tells a robot that was never there from one that has no goals."""

from collections.abc import Awaitable, Callable
from contextlib import suppress

from dock_gateway.core.errors import NotFound
from dock_gateway.core.filters import is_under
from dock_gateway.core.grant import Grant
from dock_gateway.core.namespace import read_namespace
from dock_gateway.goals.robot_actions import RobotActions
from dock_gateway.robots.robots import RobotLabels, Robots
from dock_gateway.settings import Settings
from dock_gateway.storage import History


class KnownRobots:
    """The robots that a report may be about: on the ROS graph, in the settings, with a label, or in the history.

    A typing error in the name of a robot must not look like a robot without failures.

    Args:
        settings: Name single robots.
        robots: The robots on the graph.
        labels: The labels of robots.
        actions: The actions of robots, on the graph and in the history.
        history: Has the battery states of robots that have left.
    """

    def __init__(
        self, settings: Settings, robots: Robots, labels: RobotLabels, actions: RobotActions, history: History
    ) -> None:
        self._settings = settings
        self._robots = robots
        self._labels = labels
        self._actions = actions
        self._history = history

    async def require(
        self, robot: str | None, grant: Grant, further: Callable[[str], Awaitable[bool]] | None = None
    ) -> None:
        """Refuse a namespace in which no robot is known. One that the grant does not cover is not looked up.

        Args:
            robot: The namespace, as a request names it; None if it names none.
            grant: The grant of who asks.
            further: Returns whether a robot that is not known otherwise is in what is asked for.

        Raises:
            InvalidField: The namespace is not valid.
            NotFound: `robot_not_found`.
            Unavailable: The history does not answer (`history_unavailable`).
        """
        if robot is None or not grant.covers_robot(name := read_namespace(robot)) or self._is_here(name):
            return
        if await self._actions.had_goals(name) or await self._history.has_battery(name):
            return
        if further is None or not await further(name):
            raise NotFound(f"there is no robot {name}, and the history has none", code="robot_not_found")

    def _is_here(self, name: str) -> bool:
        named = {*self._robots.namespaces(), *self._labels.robots(), *self._settings.robots}
        if any(is_under(each, name) for each in named) or self._actions.on_graph_below(name):
            return True
        with suppress(NotFound):
            self._robots.find(name)
            return True
        return False
