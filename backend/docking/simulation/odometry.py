"""Odometry: the robot's own reckoning from its wheels, which drifts."""

import math
from dataclasses import dataclass, replace
from random import Random

from docking.core.geometry import Pose, normalize_angle
from docking.core.observation import Odometry, Velocity
from docking.core.parameter import number, switch


@dataclass(frozen=True, slots=True)
class OdometrySettings:
    """Settings of how well the robot knows its wheels.

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
    stamp_offset: float = number(
        0.0, -86400.0, 86400.0, "s", "How far the clock of odometry's stamps is ahead of that of the other sensors."
    )
    repeat_every: float = number(
        0.0, 0.0, 3600.0, "s", "Time between the moments at which odometry begins to repeat its last message; 0: never."
    )
    repeat_for: float = number(0.0, 0.0, 3600.0, "s", "Time for which it does.")
    repeat_stamps: bool = switch(
        False, "Whether a repeated message has the stamp of the first one, too; else its stamp is new."
    )

    def repeats(self, now: float) -> bool:
        """Whether odometry repeats its last message.

        Args:
            now: Seconds since the start.
        """
        return 0.0 < self.repeat_every <= now and now % self.repeat_every < self.repeat_for


class DriftingOdometry:
    """The pose in odom, reckoned from what the wheels turn; where they slip, it is wrong.

    Attributes:
        x: Of base_link in odom, in m.
        y: The same.
        theta: The same, in rad.
    """

    __slots__ = ("_left", "_right", "_separation", "theta", "x", "y")

    def __init__(self, settings: OdometrySettings, wheel_separation: float, random: Random) -> None:
        """Start at the current pose of the robot.

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
            left: Motion of the left wheel, as a distance in m or a speed in m/s.
            right: The same for the right one.
        """
        left, right = left * self._left, right * self._right
        return 0.5 * (left + right), (right - left) / self._separation

    def velocity(self, wheels: Velocity) -> Velocity:
        """Return the velocity that odometry makes of the motion of the wheels.

        Args:
            wheels: Their motion.
        """
        half = 0.5 * self._separation * wheels.angular_z
        return Velocity(*self.measure(wheels.linear_x - half, wheels.linear_x + half), wheels.linear_y)

    def step(self, left: float, right: float, side: float = 0.0) -> None:
        """Update with the distances, in m, that the wheels have turned; `side` is the one to the left."""
        way, turn = self.measure(left, right)
        heading = self.theta + 0.5 * turn
        self.x += way * math.cos(heading) - side * math.sin(heading)
        self.y += way * math.sin(heading) + side * math.cos(heading)
        self.theta = normalize_angle(self.theta + turn)


class Repeater:
    """Repeats the last message of odometry while it is frozen, or the settings say so."""

    def __init__(self) -> None:
        self._last: tuple[float, Odometry] | None = None

    def pass_on(
        self, stamp: float, reading: Odometry, now: float, settings: OdometrySettings, *, frozen: bool = False
    ) -> tuple[float, Odometry]:
        """Return the message to send now: its stamp, and the odometry.

        Args:
            stamp: As it is right.
            reading: The measurement.
            now: Seconds since the start.
            settings: When to repeat what was sent before.
            frozen: Whether to repeat it whatever they say, with new stamps.
        """
        if self._last is None or not (frozen or settings.repeats(now)):
            self._last = stamp, reading
            return self._last
        first, before = self._last
        return first if settings.repeat_stamps and not frozen else stamp, replace(before, stamp=reading.stamp)
