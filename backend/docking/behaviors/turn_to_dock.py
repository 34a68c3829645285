"""Turns to the dock, on the spot."""

import math

from docking.behaviors.moves import turn
from docking.core.geometry import normalize_angle
from docking.core.observation import STANDSTILL, Observation, Velocity
from docking.goal.behavior import Done
from docking.goal.plan import DockTarget
from docking.parameters import MotionLimits

STRAIGHT = math.radians(1.5)
"""How straight the robot must look along the dock's axis, in rad."""


class TurnToDock:
    """Done when the robot is turned as it is when docked."""

    def __init__(self, aim: DockTarget, motion: MotionLimits) -> None:
        """Begin in front of the dock.

        Args:
            aim: Where the dock is.
            motion: What the robot may do.
        """
        self._aim = aim
        self._motion = motion

    def step(self, observation: Observation, dt: float) -> Velocity | Done:
        """Turn on."""
        docked, odometry = self._aim.docked, observation.odometry
        if docked is None or odometry is None:
            return STANDSTILL
        error = normalize_angle(docked.theta - odometry.pose.theta)
        return Done() if abs(error) < STRAIGHT else turn(error, self._motion)
