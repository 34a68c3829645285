"""Tracks which robots have left the ROS graph, and removes those that have been away for long."""

import logging

from dock_gateway.core.errors import GatewayError
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.goals.robot_actions import RobotActions
from dock_gateway.latch.interlock import Interlock
from dock_gateway.robots.last_goals import LastGoals
from dock_gateway.robots.registry import Robot, RobotRegistry
from dock_gateway.ros.graph import Scan

log = logging.getLogger(__name__)

# Maximum seconds between two checks.
INTERVAL = 10.0
# Seconds of absence, at most, after which a robot without a past is removed. A restart of its server takes less.
WITHOUT_PAST = 10.0


class Departures:
    """Removes robots that are away, except the configured one.

    A robot that has never had a battery, a base or a goal was only an action server or a topic: it goes with that.

    Args:
        robots: The robots.
        actions: The actions, with the robots' goals.
        robot_actions: Which of them dock and undock each robot.
        interlock: The latched stops.
        last_goals: How the robots' goals ended.
        forget_after: Seconds of absence before a robot is removed; 0 means never.
    """

    def __init__(
        self,
        robots: RobotRegistry,
        actions: ActionRegistry,
        robot_actions: RobotActions,
        interlock: Interlock,
        last_goals: LastGoals,
        *,
        forget_after: float,
    ) -> None:
        self._robots = robots
        self._actions = actions
        self._robot_actions = robot_actions
        self._interlock = interlock
        self._last_goals = last_goals
        self._forget_after = forget_after
        self._interval = min(INTERVAL, forget_after / 10)
        self._seen: dict[str, float] = {}  # when each robot was last present, in seconds
        self._bases: set[str] = set()  # the robots that have had a base
        self._looked_at = float("-inf")

    async def check(self, scan: Scan, seconds: float) -> None:
        """Check which robots are present; remove those that have been away for long and are not needed.

        Args:
            scan: The current graph.
            seconds: The current time on a monotonic clock, in seconds.

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
                    log.info("robot %s left the ROS graph", robot.namespace)
                    self._seen.pop(robot.namespace, None)
                    self._bases.discard(robot.namespace)
                    await self._robots.leave(robot.namespace)
                    self._robots.forget(robot.namespace)
                    self._robot_actions.forget(robot.namespace)
            except GatewayError:  # the others would fail too
                raise
            except Exception:
                log.exception("while checking whether robot %s left the ROS graph", robot.namespace)

    async def _is_overdue(self, robot: Robot, scan: Scan, seconds: float) -> bool:
        name, age = robot.namespace, robot.battery.age
        past = self._has_past(robot)
        if not past:
            parts = await self._robots.parts(name, scan)
            there = bool(parts)
            if past := "base" in parts:
                self._bases.add(name)
        if past:
            there = await self._robots.is_there(name, scan)
        if there:
            self._seen[name] = seconds
        elif age is not None:  # a battery that another gateway publishes counts, too
            self._seen[name] = max(self._seen.get(name, seconds - age), seconds - age)
        limit = self._forget_after if past else min(WITHOUT_PAST, self._forget_after)
        away = seconds - self._seen.setdefault(name, seconds) > limit
        return away and not self._is_needed(robot)

    def _has_past(self, robot: Robot) -> bool:
        """Return whether it has had a battery, a base or a goal."""
        names = self._robot_actions.docking_names(robot.namespace)
        return (
            robot.battery.age is not None or robot.namespace in self._bases or self._last_goals.last(*names) is not None
        )

    def _is_needed(self, robot: Robot) -> bool:
        """Return whether the robot has an unfinished goal, is held by a stop, or has its battery published by us."""
        unfinished = (*self._actions.running(), *self._actions.lost())
        return (
            self._interlock.holds(robot.namespace)
            or robot.publisher.active
            or any(self._robots.owner(goal.action_name) is robot for goal in unfinished)
        )
