"""Turns to the left and to the right in front of the dock, slowly, to see its marker from one place."""

import math
from collections.abc import Callable
from dataclasses import replace

from docking.behaviors.moves import turn
from docking.core.geometry import normalize_angle
from docking.core.observation import STANDSTILL, Observation, Velocity
from docking.goal.behavior import Done
from docking.parameters import MotionLimits

SIDE = math.radians(25.0)
"""How far to turn to either side, in rad: a usual camera still sees the marker."""
SPEED = 0.35
"""How fast at most, in rad/s: each detection counts."""
CLOSE = math.radians(3.0)
"""How near to its angle a turn must come, in rad."""
LONGEST = 15.0
"""Seconds after which the robot stops anyhow."""


class LookAround:
    """Done when enough is known, or after two turns to either side."""

    def __init__(self, motion: MotionLimits, knows: Callable[[], bool]) -> None:
        """Turn about where the robot looks at the first step.

        Args:
            motion: Limits of the robot's motion.
            knows: Whether enough is known.
        """
        self._motion = replace(motion, v_angular_max=min(SPEED, motion.v_angular_max))
        self._knows = knows
        self._sides = [SIDE, -SIDE, SIDE, -SIDE, 0.0]
        self._middle: float | None = None
        self._elapsed = 0.0

    def step(self, observation: Observation, dt: float) -> Velocity | Done:
        """Turn on; without odometry stand still."""
        if observation.odometry is None:
            return STANDSTILL
        heading = observation.odometry.pose.theta
        self._middle = heading if self._middle is None else self._middle
        self._elapsed += dt
        if self._elapsed > LONGEST or not self._sides or self._knows():
            return Done()
        error = normalize_angle(self._middle + self._sides[0] - heading)
        if abs(error) > CLOSE:
            return turn(error, self._motion.with_braking(observation.braking))
        self._sides.pop(0)
        return STANDSTILL
