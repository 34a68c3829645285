"""Readings that stay the same although the robot moves: a driver repeats them, with new stamps."""

import math

import numpy as np

from docking.core.geometry import Pose, normalize_angle
from docking.core.observation import InfraredReading, Scan
from robot_io.laser import Points

EXACT = 1e-6
"""In m; no scanner is so exact."""
FEWEST = 3
"""Points of a scan that says something."""


class Repetition:
    """Notes where the robot was when a reading came first, and how far it has moved since.

    Attributes:
        repeats: Whether the reading is repeated.
    """

    def __init__(self, way: float, turn: float) -> None:
        """Begin without a reading.

        Args:
            way: How far the robot may move with one reading, in m.
            turn: How far it may turn, in rad.
        """
        self.repeats = False
        self._way, self._turn = way, turn
        self._first: Pose | None = None

    def check(self, robot: Pose, *, same: bool) -> bool:
        """Take in a reading, and say whether it is repeated.

        Args:
            robot: base_link in odom.
            same: Whether it is the same as the one before.
        """
        if not same or self._first is None:
            self._first, self.repeats = robot, False
        turned = abs(normalize_angle(robot.theta - self._first.theta))
        self.repeats |= robot.distance_to(self._first) > self._way or turned > self._turn
        return self.repeats


class RepeatedScan:
    """Recognizes a laser scan that is repeated, wherever odometry puts its points."""

    def __init__(self) -> None:
        """Begin without a scan."""
        self._repetition = Repetition(0.05, 0.1)
        self._last: Points | None = None
        self._stamp = -math.inf

    def check(self, scan: Scan, robot: Pose) -> bool:
        """Take in a scan, and say whether it is repeated.

        Args:
            scan: The latest.
            robot: base_link in odom.
        """
        if scan.stamp == self._stamp:  # the same message: the next one has not come yet
            return self._repetition.repeats
        self._stamp, points = scan.stamp, scan.points
        shape = np.hypot(*(points - points[:1]).T) if len(points) >= FEWEST else None
        last, self._last = self._last, shape
        same = (
            shape is not None
            and last is not None
            and shape.shape == last.shape
            and bool(np.allclose(shape, last, rtol=0.0, atol=EXACT))
        )
        return self._repetition.check(robot, same=same)


class RepeatedRanges:
    """Recognizes readings of the infrared receivers that are repeated: some distance, to the last digit."""

    def __init__(self) -> None:
        """Begin without a reading."""
        self._repetition = Repetition(0.15, 0.5)
        self._last: tuple[float, float, float] | None = None

    @property
    def repeats(self) -> bool:
        """Whether the last reading was repeated."""
        return self._repetition.repeats

    def check(self, reading: InfraredReading, robot: Pose) -> bool:
        """Take in a reading, and say whether it is repeated.

        Args:
            reading: A new one.
            robot: base_link in odom.
        """
        ranges = reading.left, reading.center, reading.right
        sees = any(np.isfinite(ranges))
        last, self._last = self._last, ranges
        return self._repetition.check(robot, same=sees and ranges == last)
