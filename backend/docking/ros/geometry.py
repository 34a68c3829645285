"""Poses in the plane out of geometry_msgs, and back."""

import math

from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point, PoseStamped, Quaternion
from geometry_msgs.msg import Pose as PoseMessage

from docking.core.geometry import Pose, quaternion_of, yaw_of

UNIT_TOLERANCE = 0.1


def pose_from(message: PoseMessage) -> Pose:
    """The pose in the plane that a message means.

    Raises:
        ValueError: It is none; the error is a sentence's second half.
    """
    position, turn = message.position, message.orientation
    norm = math.hypot(turn.x, turn.y, turn.z, turn.w)
    if not (math.isfinite(position.x) and math.isfinite(position.y) and math.isfinite(norm)):
        raise ValueError("has a pose that is not a number")
    if abs(norm - 1.0) > UNIT_TOLERANCE:
        raise ValueError(f"has an orientation of length {norm:.2g}, which a quaternion cannot have")
    return Pose(position.x, position.y, yaw_of(turn.x, turn.y, turn.z, turn.w))


def pose_message(pose: Pose) -> PoseMessage:
    """A pose in the plane as a message."""
    x, y, z, w = quaternion_of(pose.theta)
    return PoseMessage(position=Point(x=pose.x, y=pose.y), orientation=Quaternion(x=x, y=y, z=z, w=w))


def stamped_pose(pose: Pose, frame: str, stamp: Time) -> PoseStamped:
    """A pose in the plane, in a frame."""
    message = PoseStamped(pose=pose_message(pose))
    message.header.frame_id = frame
    message.header.stamp = stamp
    return message
