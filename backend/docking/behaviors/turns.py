"""Turns on the spot."""

import math

from docking.behaviors.moves import turn
from docking.core.geometry import normalize_angle
from docking.core.observation import STANDSTILL, Observation, Velocity
from docking.goal.behavior import Done
from docking.goal.plan import DockTarget
from docking.parameters import MotionLimits

COMPLETE = math.radians(3.0)
"""Largest remaining angle of a full turn, in rad."""
STRAIGHT = math.radians(1.5)
"""How straight the robot must look along the dock's axis, in rad."""


class Rotate:
    """Turns on the spot, as the tutorial does, until the dock is found by luck or by hand."""

    def __init__(self, speed: float = 0.15) -> None:
        self._velocity = Velocity(0.0, speed)

    def step(self, observation: Observation, dt: float) -> Velocity:
        """Return the velocity: always `speed` rad/s, counter-clockwise."""
        return self._velocity


class FullTurn:
    """A full turn to the left by odometry, which tells how much odometry misjudges turns."""

    def __init__(self, motion: MotionLimits) -> None:
        """Start at the current pose of the robot.

        Args:
            motion: Limits of the robot's motion.
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
        return Done() if self._left < COMPLETE else turn(self._left, self._motion.with_braking(observation.braking))


class TurnToDock:
    """Done when the robot is turned as it is when docked."""

    def __init__(self, aim: DockTarget, motion: MotionLimits) -> None:
        """Begin in front of the dock.

        Args:
            aim: The dock.
            motion: Limits of the robot's motion.
        """
        self._aim = aim
        self._motion = motion

    def step(self, observation: Observation, dt: float) -> Velocity | Done:
        """Turn on."""
        docked, odometry = self._aim.docked, observation.odometry
        if docked is None or odometry is None:
            return STANDSTILL
        error = normalize_angle(docked.theta - odometry.pose.theta)
        return Done() if abs(error) < STRAIGHT else turn(error, self._motion.with_braking(observation.braking))
