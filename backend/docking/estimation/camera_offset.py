"""Measures how the camera is mounted, while the robot turns on the spot in front of the marker."""

import math
from dataclasses import dataclass
from statistics import median

import numpy as np
import numpy.typing as npt

from docking.core.geometry import Pose, normalize_angle
from docking.estimation.poses import MAD

STILL = 0.015
"""How far the robot may move while it turns on the spot, in m."""
SPAN = math.radians(25.0)
"""How far it must turn at least, in rad."""
FEWEST = 25
"""Detections that are needed while it turns."""
MOST = 400
"""Detections that are kept."""
MISJUDGED = 0.2
"""The part of a turn that odometry may misjudge."""
OUTLIER = 4.0
"""Detections farther off than this, in standard deviations, are left out."""
LEAST = 0.002
"""Standard deviation of the result at least, in m: markers are not seen the same from all sides."""

Array = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Offset:
    """The distance of the camera from where it is taken to be.

    Attributes:
        x: Ahead, in base_link, in m.
        y: To the left, in m.
        deviation: Standard deviation of each, in m.
    """

    x: float
    y: float
    deviation: float


class CameraOffset:
    """Measures by detections from one place, turned differently.

    Where the camera is taken to be in the wrong place, the robot seems to move on an arc while it turns on the spot.
    A marker that is turned on its dock, or a camera that is turned, makes no such difference.
    """

    def __init__(self) -> None:
        """Begin without a detection."""
        self._seen: list[tuple[Pose, Pose]] = []  # the robot in odom, the marker as seen from there

    def add(self, marker: Pose, robot: Pose) -> None:
        """Take a detection in; one from another place begins again, unless enough is known.

        Args:
            marker: In odom.
            robot: base_link in odom.
        """
        if self._seen and self._seen[0][0].distance_to(robot) > STILL and self.measure() is None:
            self._seen.clear()
        if not self._seen or (self._seen[0][0].distance_to(robot) <= STILL and len(self._seen) < MOST):
            self._seen.append((robot, marker.relative_to(robot)))

    def measure(self) -> Offset | None:
        """Return the result; None where the robot has not turned enough in front of the marker."""
        if len(self._seen) < FEWEST:
            return None
        first, second = self._seen[0][0].theta, self._seen[0][1].theta
        turns = np.array([normalize_angle(robot.theta - first) for robot, _ in self._seen])
        headings = np.array([normalize_angle(marker.theta - second) for _, marker in self._seen])
        if float(np.ptp(turns)) < SPAN:
            return None
        slope, start = _fit_line(turns, headings)
        if abs(slope + 1.0) > MISJUDGED:
            return None
        heading = second + start + slope * turns
        cos, sin = np.cos(heading), np.sin(heading)
        x, y = (np.array([getattr(marker, axis) for _, marker in self._seen]) for axis in "xy")
        # The robot in the marker's frame: where it is, and the camera's offset, turned as the robot is.
        measured = np.concatenate((-(cos * x + sin * y), sin * x - cos * y))
        one, none = np.ones_like(x), np.zeros_like(x)
        sides = ((one, none), (none, one), (cos, -sin), (sin, cos))
        terms = np.stack([np.concatenate(side) for side in sides], 1)
        fits = np.ones(len(measured), dtype=bool)
        for _ in range(2):
            result = np.linalg.lstsq(terms[fits], measured[fits], rcond=None)[0]
            off = measured - terms @ result
            noise = MAD * float(np.median(np.abs(off)))
            both = np.hypot(off[: len(x)], off[len(x) :]) < max(OUTLIER * noise, LEAST)
            fits = np.concatenate((both, both))
        if fits.sum() < FEWEST:
            return None
        covariance = noise**2 * np.linalg.inv(terms[fits].T @ terms[fits])
        # A turn that is misjudged looks like an offset across the line of sight.
        left = headings - start - slope * turns
        misjudged = MAD * float(np.median(np.abs(left))) / math.sqrt(float(np.sum((turns - turns.mean()) ** 2)))
        across = misjudged * float(np.median(np.hypot(x, y)))
        deviation = math.sqrt(float(covariance[2:, 2:].diagonal().max()) + across**2 + LEAST**2)
        return Offset(float(result[2]), float(result[3]), deviation)


def _fit_line(xs: Array, ys: Array) -> tuple[float, float]:
    """Slope and start of the straight line through most of the points."""
    fits = np.ones(len(xs), dtype=bool)
    slope, start = 0.0, 0.0
    for _ in range(3):
        slope, start = (float(value) for value in np.polyfit(xs[fits], ys[fits], 1))
        off = np.abs(ys - start - slope * xs)
        fits = off <= max(OUTLIER * MAD * median(off.tolist()), 1e-6)
    return slope, start
