"""A laser scan and a path, reduced to what can be seen on a map. Plain data.

Points are chosen among those that can be drawn, so that whatever can be drawn is seen, however the rest is distributed.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

from dock_gateway.core.scene import FARTHEST
from robot_io.laser import Points, flatten, points_of
from robot_io.transform import Transform

# Points (x, y) in metres.
Line = list[list[float]]

# The most points of a scan and of a path on a map.
MAX_POINTS = 360
MAX_READINGS = 100_000


def scan_points(message: Any, lies: Transform, most: int = MAX_POINTS) -> Line:
    """Return the points that a `sensor_msgs/LaserScan` sees: of neighbours the nearest, and the first and last ones.

    Args:
        message: The scan.
        lies: The scanner, in the frame that the points are to be given in.
        most: Maximum number of points.

    Raises:
        ValueError: The scan makes no sense, or lies nowhere; the error says why.
    """
    ranges = np.asarray(message.ranges)
    if len(ranges) > MAX_READINGS:
        raise ValueError(f"has {len(ranges):,} readings, more than {MAX_READINGS:,}")
    points = points_of(
        ranges,
        angle_min=message.angle_min,
        angle_increment=message.angle_increment,
        range_min=message.range_min,
        range_max=message.range_max,
    )
    if len(ranges) and not len(points) and not np.isposinf(ranges).any():  # which would be an empty room
        limits = f"{message.range_min:g} to {message.range_max:g} m"
        raise ValueError(f"has no reading within its limits of {limits} among {len(ranges):,}")
    placed = _placed(points, lies)
    return _line(placed[_nearest(np.hypot(*(placed - lies.translation[:2]).T), most)])


def path_points(message: Any, lies: Transform) -> Line:
    """Return the points of a `nav_msgs/Path`, at most `MAX_POINTS`, with its ends and its outermost points.

    Args:
        message: The path.
        lies: The path's frame, in the one that the points are to be given in.

    Raises:
        ValueError: None of its points is finite.
    """
    positions = (pose.pose.position for pose in message.poses)
    points = _placed(np.array([(point.x, point.y) for point in positions], dtype=np.float64).reshape(-1, 2), lies)
    if len(points) > MAX_POINTS:
        ends = (0, len(points) - 1)
        outermost = np.setdiff1d((points.argmin(axis=0), points.argmax(axis=0)), ends)
        points = points[np.union1d(spread(len(points), MAX_POINTS - len(outermost)), outermost)]
    return _line(points)


def spread(count: int, most: int) -> npt.NDArray[np.intp]:
    """Return at most `most` indices of a sequence, evenly distributed, in order, with the first and the last one."""
    return np.unique(np.linspace(0, count - 1, min(count, most)).round().astype(np.intp))


def _nearest(distances: npt.NDArray[np.float64], most: int) -> npt.NDArray[np.intp]:
    """Return the indices of the least distance of each group of neighbours, and of the first and the last one."""
    count = len(distances)
    if count <= most:
        return np.arange(count)
    group = np.arange(count) * (most - 2) // count
    order = np.lexsort((distances, group))
    _, firsts = np.unique(group[order], return_index=True)
    return np.union1d(order[firsts], (0, count - 1))


def _placed(points: Points, lies: Transform) -> Points:
    """Return the points in another frame, without those that are not finite or too far away."""
    with np.errstate(all="ignore"):
        placed = flatten(points, lies)
    near = placed[(np.abs(placed) <= FARTHEST).all(axis=1)]  # nor is a NaN
    if len(points) and not len(near):
        raise ValueError("has only points that are not finite, or too far away")
    return near


def _line(points: Points) -> Line:
    line: Line = np.round(points, 3).tolist()
    return line
