"""Explains why a robot has no docking server, from the docking servers and batteries on the ROS graph."""

from collections.abc import Iterator
from contextlib import contextmanager

from dock_gateway.core.errors import GatewayError
from dock_gateway.core.grant import UNLIMITED, Grant
from dock_gateway.core.namespace import normalize_namespace
from dock_gateway.goals.hints import Hint, Sight, docking_hint
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.robots.registry import Robot, RobotRegistry
from dock_gateway.settings import Settings

# The errors of a robot that is not there, or has no docking server.
NO_DOCKING_SERVER = frozenset({"action_not_found", "action_server_unavailable", "robot_not_found"})


class DockingHints:
    """Collects the docking servers and batteries on the graph, and makes hints of them.

    Args:
        settings: Say which topic a robot's battery has.
        actions: All actions.
        robots: All robots.
    """

    def __init__(self, settings: Settings, actions: ActionRegistry, robots: RobotRegistry) -> None:
        self._settings = settings
        self._actions = actions
        self._robots = robots

    def sights(self, grant: Grant = UNLIMITED) -> list[Sight]:
        """Return which docking servers and batteries are on the graph, of the robots of a grant."""
        return [self._sight(robot) for robot in self._robots.all() if grant.covers_robot(robot.namespace)]

    def _sight(self, robot: Robot) -> Sight:
        name = robot.namespace
        dock, undock = (state.action_name if state.available else None for state in self._actions.servers_of(name))
        battery = None if robot.battery.age is None else self._settings.battery_of(name)
        return Sight(name, dock, undock, battery)

    def hint(self, robot: str | None, grant: Grant) -> Hint | None:
        """Return the hint for a robot without a docking server; None if nothing on the graph helps."""
        name = self._robots.default_namespace if robot is None else normalize_namespace(robot)
        return docking_hint(name, self.sights(grant))

    @contextmanager
    def hinting(self, robot: str | None, grant: Grant) -> Iterator[None]:
        """Add a hint to the error that a robot is not there or has no docking server.

        Args:
            robot: The robot's namespace; None for the configured one.
            grant: Only what it covers is named.

        Raises:
            GatewayError: What was raised within, with the hint in its detail, and `settings` and `robots`.
        """
        try:
            yield
        except GatewayError as error:
            if error.code in NO_DOCKING_SERVER and (hint := self.hint(robot, grant)) is not None:
                error.detail = f"{error.detail}. {hint.detail}"
                error.extra.update(settings=hint.settings, robots=hint.robots)
            raise
