"""Since when robots stand still, and when a person last intervened."""

import logging
import time
from collections.abc import Callable, Collection

import orjson

from dock_gateway.core.goal import Goal, GoalStatus, Json
from dock_gateway.robots.registry import RobotRegistry

log = logging.getLogger(__name__)


class Activity:
    """Notes what robots do, for automatic docking. Velocity is subscribed to only for robots that are about to dock.

    Args:
        robots: The robots.
    """

    def __init__(self, robots: RobotRegistry) -> None:
        self._robots = robots
        self._active_at: dict[str, float] = {}  # on the monotonic clock, as all times here
        self._watched_since: dict[str, float] = {}
        self._subscribed: dict[str, tuple[float, Callable[[], bool]]] = {}  # since when, and whether all is heard
        self._person_at: dict[str, float] = {}
        self._not_numbers: set[str] = set()  # robots whose velocity was no number, which is logged once
        self._changed: Callable[[], None] = lambda: None

    def subscribed(self, robot: str, hears_all: Callable[[], bool]) -> None:
        """Note that the velocity of a robot is heard from now on. Called on the ROS thread.

        Args:
            robot: The robot.
            hears_all: Tells whether all of it is heard at the moment.
        """
        self._subscribed[robot] = time.monotonic(), hears_all

    def unsubscribed(self, robot: str) -> None:
        """Note that the velocity of a robot is no longer heard. Called on the ROS thread."""
        self._subscribed.pop(robot, None)

    def active(self, robot: str) -> None:
        """Note that a robot moves or runs a goal now."""
        self._active_at[robot] = time.monotonic()

    def on_velocity(self, robot: str, message: Json) -> None:
        """Note a message of a robot's velocity topic, unless it commands the robot to stand still.

        A value that is no number, null here, is not standing still: what a base does with it is unknown.
        """
        values = [value for vector in orjson.loads(message).values() for value in vector.values()]
        if None in values and robot not in self._not_numbers:
            self._not_numbers.add(robot)
            log.warning("velocities of %s are NaN or infinite, which counts as motion: no rule docks it", robot)
        if any(value is None or value for value in values):
            self.active(robot)

    def intervened(self, robot: str) -> None:
        """Note that a person has canceled a goal of a robot."""
        self._person_at[robot] = time.monotonic()
        self.active(robot)

    def on_end(self, goal: Goal) -> None:
        """Note the end of a goal."""
        if (robot := self._robots.owner(goal.action_name)) is None:
            return
        note = self.intervened if goal.status is GoalStatus.CANCELED else self.active
        note(robot.namespace)

    def still_since(self, robot: str) -> float | None:
        """Return since when a robot has been seen to be still.

        None if its velocity is not heard in full, which counts as motion.
        """
        watched, subscribed = self._watched_since.get(robot), self._subscribed.get(robot)
        if watched is None or subscribed is None:
            return None
        since, hears_all = subscribed
        if not hears_all():
            self.active(robot)
            return None
        return max(watched, since, self._active_at.get(robot, watched))

    def person_at(self, robot: str) -> float | None:
        """Return when a person last intervened; None if never."""
        return self._person_at.get(robot)

    def keep(self, robots: Collection[str]) -> None:
        """Forget robots that have left."""
        for times in (self._active_at, self._person_at):
            for gone in times.keys() - robots:
                del times[gone]
        self._not_numbers.intersection_update(robots)

    # ------------------------------------------------------------------ whose velocity is subscribed to

    def watch(self, robots: set[str]) -> None:
        """Watch the velocity of these robots, and of no others."""
        now = time.monotonic()
        if robots != self._watched_since.keys():
            self._watched_since = {robot: self._watched_since.get(robot, now) for robot in robots}
            self._changed()

    def watched(self, topic: str) -> set[str]:
        """Return the robots whose velocity is wanted."""
        return set(self._watched_since)

    def on_watch(self, topic: str, changed: Callable[[], None]) -> None:
        """Register `changed`, to be called when other robots are wanted."""
        self._changed = changed
