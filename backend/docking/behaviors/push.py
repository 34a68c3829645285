"""Pushes on at the dock: contacts may be on springs, or behind a lip."""

from docking.core.geometry import Pose
from docking.core.observation import STANDSTILL, Observation, Velocity
from docking.goal.behavior import Done
from docking.parameters import MotionLimits

LONGER = 3.0
"""How much longer than the way takes the robot pushes at most, in s: a base needs a moment to get over a lip."""


class Push:
    """Straight on at the lowest speed, also while the wheels stand.

    Attributes:
        pushing: Whether it was stepped; the plan clears it with each observation.
    """

    def __init__(self, distance: float, motion: MotionLimits) -> None:
        """Begin where the robot has touched, or at the docked pose.

        Args:
            distance: How far to push, in m.
            motion: Limits of the robot's motion.
        """
        self.pushing = False
        self._distance = distance
        self._velocity = Velocity(motion.v_linear_min)
        self._left = distance / motion.v_linear_min + LONGER
        self._start: Pose | None = None

    def step(self, observation: Observation, dt: float) -> Velocity | Done:
        """Push on; without odometry stand still."""
        if observation.odometry is None:
            return STANDSTILL
        self._start = self._start or observation.odometry.pose
        self.pushing = True
        self._left -= dt
        moved = observation.odometry.pose.relative_to(self._start).x
        return Done() if moved >= self._distance or self._left <= 0.0 else self._velocity
