"""Poses and stamps out of messages, and back."""

import math
from collections.abc import Sequence

from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point, PoseStamped, Quaternion, Vector3
from geometry_msgs.msg import Pose as PoseMessage
from geometry_msgs.msg import Transform as TransformMessage
from nav_msgs.msg import Path

from docking.core.geometry import Pose, quaternion_of, yaw_of
from robot_io.transform import Transform

UNIT_TOLERANCE = 0.1


def seconds_of(stamp: Time) -> float:
    """A stamp in seconds."""
    return float(stamp.sec + stamp.nanosec / 1e9)


def pose_from(message: PoseMessage) -> Pose:
    """The pose in the plane that a message means.

    Raises:
        ValueError: It is none; the caller adds the subject to the message.
    """
    position, turn = message.position, message.orientation
    norm = math.hypot(turn.x, turn.y, turn.z, turn.w)
    _check(norm, position.x, position.y)
    return Pose(position.x, position.y, yaw_of(turn.x, turn.y, turn.z, turn.w))


def transform_from(translation: Point | Vector3, rotation: Quaternion) -> Transform:
    """The transform in space that a translation and a rotation mean.

    Raises:
        ValueError: It is none; the caller adds the subject to the message.
    """
    norm = math.hypot(rotation.x, rotation.y, rotation.z, rotation.w)
    _check(norm, translation.x, translation.y, translation.z)
    return Transform(
        (translation.x, translation.y, translation.z),
        (rotation.x / norm, rotation.y / norm, rotation.z / norm, rotation.w / norm),
    )


def _check(norm: float, *numbers: float) -> None:
    """Raise ValueError where a position and an orientation of this length are no pose."""
    if not all(map(math.isfinite, (norm, *numbers))):
        raise ValueError("has a pose that is not a number")
    if abs(norm - 1.0) > UNIT_TOLERANCE:
        raise ValueError(f"has an orientation of length {norm:.2g}, which a quaternion cannot have")


def pose_in_space(transform: Transform) -> PoseMessage:
    """A pose in space as a message."""
    x, y, z, w = transform.rotation
    point = Point(**dict(zip("xyz", transform.translation, strict=True)))
    return PoseMessage(position=point, orientation=Quaternion(x=x, y=y, z=z, w=w))


def transform_message(transform: Transform) -> TransformMessage:
    """A transform as a message."""
    (x, y, z), turn = transform.translation, transform.rotation
    rotation = Quaternion(x=turn[0], y=turn[1], z=turn[2], w=turn[3])
    return TransformMessage(translation=Vector3(x=x, y=y, z=z), rotation=rotation)


def pose_message(pose: Pose) -> PoseMessage:
    """A pose in the plane as a message."""
    x, y, z, w = quaternion_of(pose.theta)
    return PoseMessage(position=Point(x=pose.x, y=pose.y), orientation=Quaternion(x=x, y=y, z=z, w=w))


def path_message(poses: Sequence[Pose], frame: str, stamp: Time) -> Path:
    """Poses in the plane, one after another."""
    message = Path(poses=[stamped_pose(pose, frame, stamp) for pose in poses])
    message.header.frame_id = frame
    message.header.stamp = stamp
    return message


def stamped_pose(pose: Pose, frame: str, stamp: Time) -> PoseStamped:
    """A pose in the plane, in a frame."""
    message = PoseStamped(pose=pose_message(pose))
    message.header.frame_id = frame
    message.header.stamp = stamp
    return message
