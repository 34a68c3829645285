"""Measures the noise of the detections of the marker by their distance from the prediction."""

import math
from collections import deque
from statistics import median

from docking.core.geometry import Pose

POSITION = 0.01
"""Standard deviation of a detection, in m, until it has been measured."""
DISTANCE = 0.5
"""How much more it is for each m that the marker is away, as a fraction."""
ANGLE = math.radians(1.5)
"""Standard deviation of a detection, in rad, until it has been measured."""
LIMITS = (0.5, 8.0)
"""Bounds of the measured noise, as multiples of the three above."""
TRUST = 5
"""How many measurements of the noise the assumption counts as."""
MEASURED = 60
"""Detections from which the noise is measured: their median, since a third may be wrong."""
MEDIAN_2, MEDIAN_1 = 1.386, 0.455
"""Median of the sum of two squared standard normal variables, and of one."""


class DetectionNoise:
    """The variances of detections, as multiples of the usual ones.

    Attributes:
        scales: Of position and angle, as measured.
    """

    def __init__(self) -> None:
        """Assume the usual noise."""
        self.scales = (1.0, 1.0)
        self._assumed = self.scales  # the largest since the estimate began
        self._positions: deque[float] = deque(maxlen=MEASURED)
        self._angles: deque[float] = deque(maxlen=MEASURED)

    def variances(self, distance: float) -> tuple[float, float]:
        """Of a coordinate, in m², and of the angle, in rad², of a marker at a distance in m."""
        return _scaled(distance, self.scales)

    def learn(self, off: Pose, distance: float) -> tuple[float, float]:
        """Take in how far a detection is off.

        Args:
            off: The part of the distance from the prediction that the detection's noise explains.
            distance: To the marker, in m.

        Returns:
            The factors by which the variances of position and angle of what was estimated must grow: where detections
            are noisier than was assumed, the earlier ones were as noisy.
        """
        self._positions.append((off.x**2 + off.y**2) / _usual(distance) ** 2 / MEDIAN_2)
        self._angles.append((off.theta / ANGLE) ** 2 / MEDIAN_1)
        self.scales = _scale(self._positions), _scale(self._angles)
        growth = tuple(max(1.0, now / assumed) for now, assumed in zip(self.scales, self._assumed, strict=True))
        self._assumed = (self._assumed[0] * growth[0], self._assumed[1] * growth[1])
        return growth[0], growth[1]

    def begin(self) -> None:
        """An estimate begins that assumes the noise as it is measured now."""
        self._assumed = self.scales

    def forget(self) -> None:
        """Forget all measurements: they were wrong."""
        self._positions.clear()
        self._angles.clear()


def most(distance: float) -> tuple[float, float]:
    """The largest variances that detections at a distance in m may have."""
    return _scaled(distance, (LIMITS[1] ** 2, LIMITS[1] ** 2))


def _usual(distance: float) -> float:
    return POSITION * (1.0 + DISTANCE * distance)


def _scaled(distance: float, scales: tuple[float, float]) -> tuple[float, float]:
    return _usual(distance) ** 2 * scales[0], ANGLE**2 * scales[1]


def _scale(measured: deque[float]) -> float:
    number = len(measured)
    return min(LIMITS[1] ** 2, max(LIMITS[0] ** 2, (TRUST + number * median(measured)) / (TRUST + number)))
