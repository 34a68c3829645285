"""Differences and medians of poses, coordinate by coordinate."""

from collections.abc import Sequence
from statistics import median

from docking.core.geometry import Pose, normalize_angle

MAD = 1.4826
"""A standard deviation as a multiple of the median absolute deviation, for normal noise."""


def difference(one: Pose, other: Pose) -> Pose:
    """Return the difference of each coordinate."""
    return Pose(one.x - other.x, one.y - other.y, normalize_angle(one.theta - other.theta))


def squared_distance(off: Pose, noise: tuple[float, float]) -> float:
    """Squared length of a difference, in standard deviations.

    Args:
        off: The difference.
        noise: Variances of a coordinate, in m², and of the angle, in rad².
    """
    return (off.x**2 + off.y**2) / noise[0] + off.theta**2 / noise[1]


def median_pose(poses: Sequence[Pose]) -> Pose:
    """Return the median of each coordinate."""
    first = poses[0].theta
    theta = first + median(normalize_angle(pose.theta - first) for pose in poses)
    return Pose(median(pose.x for pose in poses), median(pose.y for pose in poses), normalize_angle(theta))
