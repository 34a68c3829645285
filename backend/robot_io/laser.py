"""Points that a laser scanner sees."""

import math

import numpy as np
import numpy.typing as npt

from robot_io.transform import Transform

Points = npt.NDArray[np.float64]
"""Shape (n, 2): x and y in m."""

NOWHERE: Points = np.empty((0, 2))


def points_of(
    ranges: npt.ArrayLike,
    *,
    angle_min: float,
    angle_increment: float,
    range_min: float,
    range_max: float,
) -> Points:
    """The points of a sensor_msgs/LaserScan in the scanner's frame; readings outside of the range limits are left out.

    Raises:
        ValueError: The scan makes no sense; the caller adds the subject to the message.
    """
    if not (math.isfinite(angle_min) and math.isfinite(angle_increment) and 0.0 <= range_min < range_max):
        raise ValueError("has angles or range limits that are not valid")
    distances = np.asarray(ranges, dtype=np.float64)
    angles = angle_min + angle_increment * np.arange(len(distances))
    seen = np.isfinite(distances) & (distances >= range_min) & (distances <= range_max)
    distances, angles = distances[seen], angles[seen]
    return np.column_stack((distances * np.cos(angles), distances * np.sin(angles)))


def flatten(points: Points, frame: Transform) -> Points:
    """Points of a frame in space, seen from above in the frame that it is given in: a scanner may hang upside down."""
    origin, x, y = (
        np.array(frame.compose(Transform(axis)).translation[:2]) for axis in ((0, 0, 0), (1, 0, 0), (0, 1, 0))
    )
    return np.asarray(points @ np.array((x - origin, y - origin)) + origin)
