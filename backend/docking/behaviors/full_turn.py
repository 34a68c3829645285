"""A full turn on the spot, which tells how much odometry misjudges turns."""

import math

from docking.behaviors.moves import turn
from docking.core.geometry import normalize_angle
from docking.core.observation import STANDSTILL, Observation, Velocity
from docking.goal.behavior import Done
from docking.parameters import MotionLimits

REACHED = math.radians(3.0)
"""What may be left of it, in rad."""


class FullTurn:
    """Turns to the left until odometry says that the robot looks where it looked before."""

    def __init__(self, motion: MotionLimits) -> None:
        """Begin where the robot is.

        Args:
            motion: What the robot may do.
        """
        self._motion = motion
        self._left = math.tau
        self._last: float | None = None

    def step(self, observation: Observation, dt: float) -> Velocity | Done:
        """Turn on; without odometry stand still."""
        if observation.odometry is None:
            return STANDSTILL
        heading = observation.odometry.pose.theta
        if self._last is not None:
            self._left -= normalize_angle(heading - self._last)
        self._last = heading
        return Done() if self._left < REACHED else turn(self._left, self._motion)
