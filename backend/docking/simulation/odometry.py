"""Odometry: the robot's own reckoning from its wheels, which drifts."""

import math
from dataclasses import dataclass
from random import Random

from docking.core.geometry import Pose, normalize_angle
from docking.core.parameter import number, switch


@dataclass(frozen=True, slots=True)
class OdometrySettings:
    """How well the robot knows its wheels.

    The error of a radius is drawn once, so that the error of the pose grows with the way (Borenstein and Feng, UMBmark,
    1996: unequal wheels).
    """

    drift: float = number(
        0.005,
        0.0,
        0.2,
        "",
        "Standard deviation of the error of each wheel's radius, as a fraction of the radius.",
    )
    delay: float = number(0.0, 0.0, 2.0, "s", "Time from a measurement of odometry to its arrival.")
    honest_stamps: bool = switch(
        True, "Whether the stamp of odometry is the moment of its measurement; else it is that of its arrival."
    )
    twist: bool = switch(True, "Whether odometry has a velocity; else `twist` is empty.")


class DriftingOdometry:
    """The pose in odom, reckoned from what the wheels turn; where they slip, it is wrong.

    Attributes:
        x: Of base_link in odom, in m.
        y: The same.
        theta: The same, in rad.
    """

    __slots__ = ("_left", "_right", "_separation", "theta", "x", "y")

    def __init__(self, settings: OdometrySettings, wheel_separation: float, random: Random) -> None:
        """Begin where the robot is.

        Args:
            settings: How wrong it is.
            wheel_separation: In m.
            random: Where the errors are drawn from.
        """
        self._separation = wheel_separation
        self._left = 1.0 + random.gauss(0.0, settings.drift)
        self._right = 1.0 + random.gauss(0.0, settings.drift)
        self.x = self.y = self.theta = 0.0

    @property
    def pose(self) -> Pose:
        """Of base_link in odom."""
        return Pose(self.x, self.y, self.theta)

    def measure(self, left: float, right: float) -> tuple[float, float]:
        """Forward and turning, as the wheels seem to do it.

        Args:
            left: What the left wheel does, as a way in m or a speed in m/s.
            right: The same for the right one.
        """
        left, right = left * self._left, right * self._right
        return 0.5 * (left + right), (right - left) / self._separation

    def step(self, left: float, right: float) -> None:
        """Take over the ways, in m, that the wheels have turned."""
        way, turn = self.measure(left, right)
        heading = self.theta + 0.5 * turn
        self.x += way * math.cos(heading)
        self.y += way * math.sin(heading)
        self.theta = normalize_angle(self.theta + turn)
