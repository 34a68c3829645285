"""Looks for the dock by turning on the spot."""

import math
from collections.abc import Callable

from docking.behaviors.moves import turn
from docking.core.geometry import Pose, normalize_angle
from docking.core.observation import STANDSTILL, Observation, Velocity
from docking.goal.behavior import Done
from docking.parameters import MotionLimits

LEFT, RIGHT = math.radians(100.0), math.radians(-200.0)
"""How far to turn to the left, and then to the right, before turning to the left on and on.

The dock is more often ahead than behind, and where detections are rare it may have been missed.
"""

CENTERED = math.radians(15.0)
"""How far from straight ahead a dock in view may stay, in rad."""


class Search:
    """Turns until something is seen, then stands still until enough is known."""

    def __init__(
        self,
        motion: MotionLimits,
        speed: float,
        *,
        sees: Callable[[float], bool],
        knows: Callable[[], bool],
        towards: float | None = None,
        bearing: Callable[[Pose], float | None] = lambda robot: None,
    ) -> None:
        """Start at the current pose of the robot.

        Args:
            motion: Limits of the robot's motion.
            speed: How fast to turn, in rad/s.
            sees: Whether the dock is in view at a moment.
            knows: Whether it was seen well enough.
            towards: The direction in odom to look into first, in rad; None where nothing is known.
            bearing: Where the dock in view is for a robot in odom, in rad to the left; None if it may stay there.
        """
        self._motion = motion
        self._speed = min(speed, motion.v_angular_max)
        self._sees = sees
        self._knows = knows
        self._towards = towards
        self._bearing = bearing
        self._last: float | None = None
        self._turned = 0.0
        self._leftwards = True
        self._been_right = False

    @property
    def looked_around(self) -> bool:
        """Whether the robot has looked into all directions."""
        return self._been_right

    def step(self, observation: Observation, dt: float) -> Velocity | Done:
        """Turn, or stand still and look."""
        if self._knows():
            return Done()
        odometry = observation.odometry
        if odometry is None:
            return STANDSTILL
        if self._sees(observation.now):
            return self._center(odometry.pose, self._motion.with_braking(observation.braking))
        heading = odometry.pose.theta
        if self._towards is not None:
            error = normalize_angle(self._towards - heading)
            if abs(error) > math.radians(3.0):
                return turn(error, self._motion.with_braking(observation.braking))
            self._towards = None
        if self._last is not None:
            self._turned += normalize_angle(heading - self._last)
        self._last = heading
        if self._turned > LEFT and not self._been_right:
            self._leftwards = False
        elif self._turned < RIGHT:
            self._leftwards = self._been_right = True
        return Velocity(0.0, self._speed if self._leftwards else -self._speed)

    def _center(self, robot: Pose, motion: MotionLimits) -> Velocity:
        """Turn until the dock is in the middle of the view."""
        bearing = self._bearing(robot)
        if bearing is None or abs(normalize_angle(bearing)) < CENTERED:
            return STANDSTILL
        return turn(normalize_angle(bearing), motion)
