"""Straight ways by odometry."""

import math

from docking.core.geometry import Pose, normalize_angle
from docking.core.observation import STANDSTILL, Observation, Velocity
from docking.goal.behavior import Done
from docking.parameters import MotionLimits

STEERING = 2.0
"""How hard it holds its direction, in 1/s."""


class BackOut:
    """Drives backwards along a straight line, from where the robot is at the first step."""

    def __init__(self, distance: float, motion: MotionLimits) -> None:
        """Plan the way.

        Args:
            distance: How far, in m.
            motion: What the robot may do.
        """
        self._distance = distance
        self._motion = motion
        self._start: Pose | None = None

    def step(self, observation: Observation, dt: float) -> Velocity | Done:
        """Backwards, slower towards the end; needs odometry and stands still without."""
        odometry = observation.odometry
        if odometry is None:
            return STANDSTILL
        if self._start is None:
            self._start = odometry.pose
        moved = odometry.pose.relative_to(self._start)
        left = self._distance + moved.x
        if left <= 0.005:
            return Done()
        motion = self._motion
        speed = min(motion.v_linear_back, math.sqrt(motion.a_linear_max * left), 2.0 * left + 0.01)
        # To the left of the line, a robot that drives backwards gets back to it when it is turned to the left.
        turn = STEERING * (math.atan(2.0 * moved.y) - normalize_angle(moved.theta))
        return Velocity(-speed, turn)
