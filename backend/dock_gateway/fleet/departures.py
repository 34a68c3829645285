"""Which robots have left the ROS graph, and since when: who has been away for long is forgotten."""

import logging

from dock_gateway.actions.registry import ActionRegistry
from dock_gateway.core.errors import GatewayError
from dock_gateway.latch.interlock import Interlock
from dock_gateway.robots.registry import Robot, RobotRegistry
from dock_gateway.ros.graph import Scan

log = logging.getLogger(__name__)

# Robots without an action are looked for so often, in seconds.
INTERVAL = 10.0


class Departures:
    """Forgets the robots that are away, but for the configured one.

    Args:
        robots: The robots.
        actions: Where their goals are.
        interlock: Which of them are held by a stop.
        forget_after: Seconds; 0 is never.
    """

    def __init__(
        self, robots: RobotRegistry, actions: ActionRegistry, interlock: Interlock, *, forget_after: float
    ) -> None:
        self._robots = robots
        self._actions = actions
        self._interlock = interlock
        self._forget_after = forget_after
        self._interval = min(INTERVAL, forget_after / 10)
        self._seen: dict[str, float] = {}  # when each robot was there last
        self._looked_at = float("-inf")

    async def look(self, scan: Scan, seconds: float) -> None:
        """See who is there, and forget those who have not been for long and have nothing that waits for them.

        Args:
            scan: What is on the graph.
            seconds: The time on a clock that does not jump.

        Raises:
            Unavailable: The ROS thread is down.
        """
        if not self._forget_after or seconds - self._looked_at < self._interval:
            return
        self._looked_at = seconds
        for robot in self._robots.all():
            if robot.namespace == self._robots.default_namespace:
                continue
            try:
                if await self._is_overdue(robot, scan, seconds):
                    log.info("robot %s has gone", robot.namespace)
                    self._seen.pop(robot.namespace, None)
                    self._robots.forget(robot.namespace)
            except GatewayError:  # it would be the same with the others
                raise
            except Exception:
                log.exception("while looking whether robot %s has gone", robot.namespace)

    async def _is_overdue(self, robot: Robot, scan: Scan, seconds: float) -> bool:
        name, age = robot.namespace, robot.battery.age
        if await self._robots.is_there(name, scan):
            self._seen[name] = seconds
        elif age is not None:  # a battery that another gateway publishes counts, too
            self._seen[name] = max(self._seen.get(name, seconds - age), seconds - age)
        away = seconds - self._seen.setdefault(name, seconds) > self._forget_after
        return away and not self._is_needed(robot)

    def _is_needed(self, robot: Robot) -> bool:
        """Whether a goal of the robot has not ended, a stop holds for it, or its battery is published by us."""
        unfinished = (*self._actions.running(), *self._actions.lost())
        return (
            self._interlock.holds(robot.namespace)
            or robot.publisher.active
            or any(self._robots.owner(goal.action_name) is robot for goal in unfinished)
        )
