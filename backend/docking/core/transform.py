"""Poses in space and in the plane; how the robot's frames lie in each other (REP-103, REP-105)."""

import math

import numpy as np

from docking.core.geometry import Pose, yaw_of
from robot_io.laser import Points
from robot_io.transform import Transform, turn

STEEP = 0.5
"""The least length, from above, of an x axis of length 1 that has a heading: it is tilted by 60° at most."""


def pose_of(transform: Transform) -> Pose:
    """The pose in the plane: seen from above, with the heading of the x axis.

    Raises:
        ValueError: The x axis points up or down; the caller adds the subject to the message.
    """
    x, y, z = Transform(rotation=transform.rotation).apply((1.0, 0.0, 0.0))
    if math.hypot(x, y) < STEEP:
        raise ValueError(
            f"has an x axis that points {'up' if z > 0.0 else 'down'} and so has no heading"
            " (external_detection_rotation_roll and external_detection_rotation_pitch turn it)"
        )
    return Pose(transform.translation[0], transform.translation[1], yaw_of(*transform.rotation))


def spatial(pose: Pose, height: float = 0.0) -> Transform:
    """A pose in the plane as one in space.

    Args:
        pose: In the plane.
        height: Above the plane, in m.
    """
    return Transform((pose.x, pose.y, height), turn((0.0, 0.0, 1.0), pose.theta))


def tilt(roll: float, pitch: float) -> Transform:
    """A turn about the y axis by `pitch`, then about the turned x axis by `roll`, both in rad.

    With a turn about the turned z axis by yaw after these, it is the rotation of nav2's external_detection_rotation.
    """
    about_y, about_x = turn((0.0, 1.0, 0.0), pitch), turn((1.0, 0.0, 0.0), roll)
    return Transform(rotation=about_y).compose(Transform(rotation=about_x))


def place(points: Points, frame: Pose) -> Points:
    """Points of a frame, in the frame that the frame's pose is given in."""
    cos, sin = math.cos(frame.theta), math.sin(frame.theta)
    return np.asarray(points @ np.array(((cos, sin), (-sin, cos))) + (frame.x, frame.y))
