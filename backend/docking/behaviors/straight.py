"""Straight ways by odometry."""

import math

from docking.behaviors.moves import drive_to
from docking.core.geometry import Pose, normalize_angle
from docking.core.observation import STANDSTILL, Observation, Velocity
from docking.goal.behavior import Done
from docking.parameters import MotionLimits

STEERING = 2.0
"""How hard a robot that backs out holds its direction, in 1/s."""
REACHED = 0.05
"""How near to a place it is enough, in m."""


class BackOut:
    """Drives backwards along a straight line, from where the robot is at the first step."""

    def __init__(self, distance: float, motion: MotionLimits, line: Pose | None = None) -> None:
        """Plan the way.

        Args:
            distance: How far, in m.
            motion: Limits of the robot's motion.
            line: Where the line begins, in odom, and how the robot is turned on it; None is where it is at first.
        """
        self._distance = distance
        self._motion = motion
        self._start = line

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
        motion = self._motion.with_braking(observation.braking)
        speed = min(motion.v_linear_back, math.sqrt(motion.a_linear_max * left), 2.0 * left + 0.01)
        # To the left of the line, a robot that drives backwards gets back to it when it is turned to the left.
        turn = STEERING * (math.atan(2.0 * moved.y) - normalize_angle(moved.theta))
        return Velocity(-speed, turn)


class GoTo:
    """Straight to a place; how the robot is turned there does not matter."""

    def __init__(self, place: Pose, motion: MotionLimits) -> None:
        """Plan the way.

        Args:
            place: Where base_link is to be, in odom.
            motion: Limits of the robot's motion.
        """
        self._place = place
        self._motion = motion

    def step(self, observation: Observation, dt: float) -> Velocity | Done:
        """Drive on; without odometry stand still."""
        odometry = observation.odometry
        if odometry is None:
            return STANDSTILL
        if odometry.pose.distance_to(self._place) <= REACHED:
            return Done()
        return drive_to(odometry.pose, self._place, self._motion.with_braking(observation.braking))
