"""Drives to a place, by odometry alone."""

from docking.behaviors.moves import drive_to
from docking.core.geometry import Pose
from docking.core.observation import STANDSTILL, Observation, Velocity
from docking.goal.behavior import Done
from docking.parameters import MotionLimits

REACHED = 0.05
"""How near to the place it is enough, in m."""


class GoTo:
    """Straight to a place; how the robot is turned there does not matter."""

    def __init__(self, place: Pose, motion: MotionLimits) -> None:
        """Plan the way.

        Args:
            place: Where base_link is to be, in odom.
            motion: What the robot may do.
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
        return drive_to(odometry.pose, self._place, self._motion)
