"""A ride of the simulated robot to a pose, around walls, furniture and other robots."""

import contextlib
import math
from collections.abc import Sequence
from itertools import pairwise

from docking.behaviors.moves import drive_to, turn
from docking.core.geometry import Pose, normalize_angle
from docking.core.observation import STANDSTILL, Velocity
from docking.parameters import MotionLimits
from docking.simulation.obstacle import Obstacle
from docking.simulation.route import MARGIN, NoWayError, Point, Routes

MOTION = MotionLimits()
REACHED = 0.03
"""How near to a corner of the way it is enough, in m."""
TURNED = 0.03
"""How far the robot may be turned against its goal in the end, in rad."""
AHEAD = 0.4
"""How far ahead the robot looks, in m: for obstacles, and for where to steer."""
PROGRESS = 10.0
"""Seconds within which the robot has to get on."""
LITTLE = 0.005
"""What it has to get on by, in m or rad: centimetres beside its goal it steers slowly."""

LONGEST_WAIT = 30.0
"""Seconds for which the robot waits for another one."""
LOOK_PERIOD = 2.0
"""Seconds between two looks for a way around another robot."""


class Ride:
    """Drives to a pose, corner by corner.

    Attributes:
        target: The pose, in world.
        way: The corners that are still ahead.
    """

    def __init__(
        self, routes: Routes, robot: Pose, target: Pose, radius: float, now: float, *, patience: float = 1.0
    ) -> None:
        """Find the way.

        Args:
            routes: Of the room.
            robot: Where the robot is, in world.
            target: Where it is to be.
            radius: Of the robot, in m.
            now: Simulated seconds.
            patience: Seconds that the robot waits for another one before it drives around it.

        Raises:
            NoWayError: There is none.
        """
        self.target = target
        self._routes = routes
        self._patience = patience
        self._waits_since: float | None = None
        self._look_at = now
        self._from, *self.way = routes.find(robot, (target.x, target.y))
        self._has_room = routes.is_free(self._from)
        self._radius = radius
        self._best, self._best_at = math.inf, now

    def remaining(self, robot: Pose) -> float:
        """The length of the way that is ahead, in m."""
        points: list[Point] = [(robot.x, robot.y), *self.way]
        return math.fsum(math.dist(*leg) for leg in pairwise(points))

    def step(
        self, robot: Pose, obstacles: Sequence[Obstacle], now: float, others: Sequence[Obstacle] = ()
    ) -> Velocity | None:
        """The next velocity; None when the robot is there.

        Args:
            robot: Where it is, in world.
            obstacles: What is not on the map.
            now: Simulated seconds.
            others: Other robots, for which it waits, or which it drives around.

        Raises:
            NoWayError: The robot cannot go on.
        """
        while self.way and math.dist((robot.x, robot.y), self.way[0]) < REACHED:
            self._from, self._has_room = self.way.pop(0), True
        error = normalize_angle(self.target.theta - robot.theta)
        if not self.way and abs(error) < TURNED:
            return None
        # A turn at the goal gets on, too, wherever the way has ended.
        self._note_progress(self.remaining(robot) if self.way else abs(error) - math.tau, now)
        if not self.way:
            return turn(error, MOTION)
        towards = self._look_ahead(robot, self.way[0])
        if any(self._is_in_the_way(obstacle, robot, towards) for obstacle in obstacles):
            raise NoWayError("an obstacle is in the way")
        if any(self._is_in_the_way(other, robot, towards) for other in others):
            self._wait(robot, others, now)
            return STANDSTILL
        self._waits_since = None
        return drive_to(robot, towards, MOTION, forwards=self._has_room)

    def _wait(self, robot: Pose, others: Sequence[Obstacle], now: float) -> None:
        """Wait for another robot, and look for a way around it after a while."""
        self._waits_since = now if self._waits_since is None else self._waits_since
        self._best_at = now
        waited = now - self._waits_since
        if waited > LONGEST_WAIT:
            raise NoWayError(f"another robot was in the way for {LONGEST_WAIT:g} s")
        if waited < self._patience or now < self._look_at:
            return
        self._look_at = now + LOOK_PERIOD
        routes = self._routes.around(others)
        with contextlib.suppress(NoWayError):
            self._from, *self.way = routes.find(robot, (self.target.x, self.target.y))
            self._has_room, self._best = routes.is_free(self._from), math.inf

    def _look_ahead(self, robot: Pose, corner: Point) -> Pose:
        """A point on the leg to the corner, so near that the robot soon is on the leg."""
        (x, y), length = self._from, math.dist(self._from, corner)
        along = ((robot.x - x) * (corner[0] - x) + (robot.y - y) * (corner[1] - y)) / length
        share = min(1.0, (along + AHEAD) / length)
        return Pose(x + share * (corner[0] - x), y + share * (corner[1] - y))

    def _is_in_the_way(self, obstacle: Obstacle, robot: Pose, towards: Pose) -> bool:
        length = robot.distance_to(towards)
        x, y = (towards.x - robot.x) / length, (towards.y - robot.y) / length
        along = (obstacle.x - robot.x) * x + (obstacle.y - robot.y) * y
        nearest = min(length, max(0.0, along))
        distance = math.hypot(obstacle.x - robot.x - nearest * x, obstacle.y - robot.y - nearest * y)
        return along > 0.0 and distance < obstacle.radius + self._radius + MARGIN

    def _note_progress(self, left: float, now: float) -> None:
        if left < self._best - LITTLE:
            self._best, self._best_at = left, now
        elif now - self._best_at > PROGRESS:
            raise NoWayError(f"the robot did not get on for {PROGRESS:g} s")
