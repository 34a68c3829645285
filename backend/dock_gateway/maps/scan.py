"""A laser scan and a path, reduced to what can be seen on a map. Plain data."""

import math
from typing import Any

import numpy as np

from dock_gateway.core.scene import FARTHEST
from robot_io.laser import flatten, points_of
from robot_io.transform import Transform

Line = list[list[float]]
"""Points (x, y) in metres."""

# The most points of a scan and of a path on a map.
MAX_POINTS = 360
MAX_READINGS = 100_000


def scan_points(message: Any, lies: Transform) -> Line:
    """Return the points that a `sensor_msgs/LaserScan` sees, at most `MAX_POINTS`.

    Args:
        message: The scan.
        lies: The scanner, in the frame that the points are to be given in.

    Raises:
        ValueError: The scan makes no sense, or lies nowhere; the error says why.
    """
    if len(message.ranges) > MAX_READINGS:
        raise ValueError(f"has {len(message.ranges):,} readings, more than {MAX_READINGS:,}")
    step = max(1, math.ceil(len(message.ranges) / MAX_POINTS))
    points = points_of(
        np.asarray(message.ranges)[::step],
        angle_min=message.angle_min,
        angle_increment=message.angle_increment * step,
        range_min=message.range_min,
        range_max=message.range_max,
    )
    return _placed(points, lies)


def path_points(message: Any, lies: Transform) -> Line:
    """Return the points of a `nav_msgs/Path`, at most `MAX_POINTS`, with its first and its last one.

    Args:
        message: The path.
        lies: The path's frame, in the one that the points are to be given in.

    Raises:
        ValueError: It has a point that is not finite.
    """
    poses = message.poses
    chosen = np.unique(np.linspace(0, len(poses) - 1, min(len(poses), MAX_POINTS)).round().astype(int))
    positions = [poses[index].pose.position for index in chosen]
    return _placed(np.array([(point.x, point.y) for point in positions]).reshape(-1, 2), lies)


def _placed(points: Any, lies: Transform) -> Line:
    with np.errstate(all="ignore"):
        placed = flatten(points, lies)
    if not (np.abs(placed) <= FARTHEST).all():  # nor is a NaN
        raise ValueError("has a point that is not finite, or too far away")
    line: Line = np.round(placed, 3).tolist()
    return line
