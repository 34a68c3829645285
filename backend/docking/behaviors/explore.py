"""Looks for the dock from more than one place."""

from collections.abc import Callable, Iterator

import numpy as np

from docking.behaviors.moves import drive_to
from docking.behaviors.search import Search
from docking.core.errors import FailedToDetectDock
from docking.core.geometry import Pose
from docking.core.observation import STANDSTILL, Observation, Scan, Velocity
from docking.goal.behavior import Done, Failed, Step
from docking.parameters import MotionLimits

REACHED = 0.05
"""How near to a place it is enough, in m."""
WIDTH = 0.35
"""How far from its way, in m, a point of the scan is in the way."""
LAST_LOOK = 12.0
"""For how long the robot goes on turning at the last place, in s, while it sees nothing."""
LOOKED_AHEAD = 0.8
"""How far ahead, in m, the way is looked at."""


class Explore:
    """Turns on the spot, drives to the next place where nothing was found, and turns again.

    The robot drives forwards only. It stops as soon as the dock is in view.

    Attributes:
        away: Whether it has left its first place.
    """

    def __init__(
        self,
        search: Callable[[], Search],
        places: Iterator[Pose],
        motion: MotionLimits,
        sees: Callable[[float], bool],
        *,
        at_once: bool = False,
    ) -> None:
        """Start at the current pose of the robot.

        Args:
            search: Makes what turns the robot at a place.
            places: Where to drive, in odom, one after another.
            motion: Limits of the robot's motion.
            sees: Whether the dock is in view at a moment.
            at_once: Whether to drive without looking around first.
        """
        self.away = False
        self._make_search = search
        self._places = places
        self._motion = motion
        self._sees = sees
        self._last_look = 0.0
        self._search = search()
        self._target: Pose | None = next(places, None) if at_once else None

    def step(self, observation: Observation, dt: float) -> Step:
        """Turn, or drive on."""
        self.away = self.away or self._target is not None
        if observation.odometry is None:
            return STANDSTILL
        if self._target is not None:
            return self._drive(observation, observation.odometry.pose, self._target)
        step = self._search.step(observation, dt)
        if not isinstance(step, Done) and self._search.looked_around and not self._sees(observation.now):
            self._target = next(self._places, None)
            self._last_look += dt if self._target is None and self.away else 0.0
            if self._last_look > LAST_LOOK:
                return Failed(FailedToDetectDock("the dock was not found, and there is no other place to look for it"))
        return step

    def _drive(self, observation: Observation, robot: Pose, target: Pose) -> Velocity:
        if self._sees(observation.now) or robot.distance_to(target) <= REACHED:
            self._target, self._search = None, self._make_search()
            return STANDSTILL
        if observation.scan is not None and is_blocked(observation.scan, robot, target):
            self._target = next(self._places, None)
            self._search = self._make_search()
            return STANDSTILL
        return drive_to(robot, target, self._motion.with_braking(observation.braking), forwards=True)


def is_blocked(scan: Scan, robot: Pose, target: Pose) -> bool:
    """Whether something is in the way to a place.

    Args:
        scan: The last one.
        robot: Where the robot is, in odom.
        target: Where it drives.
    """
    way = np.array((target.x - robot.x, target.y - robot.y))
    length = float(np.hypot(*way))
    if not len(scan.points) or length < REACHED:
        return False
    along = (scan.points - (robot.x, robot.y)) @ (way / length)
    across = (scan.points - (robot.x, robot.y)) @ (np.array((-way[1], way[0])) / length)
    return bool(np.any((along > 0.0) & (along < min(length, LOOKED_AHEAD) + WIDTH) & (abs(across) < WIDTH)))
