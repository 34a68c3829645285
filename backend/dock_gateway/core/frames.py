"""Frames and transforms of messages, checked: a node may send anything."""

import math
from typing import Any

from dock_gateway.core.scene import MAX_LENGTH, MIN_LENGTH
from robot_io.transform import Transform

# The longest name of a frame, in characters.
LONGEST_FRAME = 255


def frame_name(name: str) -> str:
    """Return the name of a frame as tf2 has it, without a slash at its beginning.

    Raises:
        ValueError: It is so long that it is none.
    """
    if len(name) > LONGEST_FRAME:
        raise ValueError(f"the name of a frame has more than {LONGEST_FRAME} characters")
    return name.removeprefix("/")


def transform_of(message: Any) -> Transform:
    """Return a `geometry_msgs/Transform`.

    Raises:
        ValueError: It has numbers that are no position and no rotation.
    """
    shift, turn = message.translation, message.rotation
    length = math.hypot(turn.x, turn.y, turn.z, turn.w)
    numbers = (shift.x, shift.y, shift.z, length)
    if not all(map(math.isfinite, numbers)) or not MIN_LENGTH <= length <= MAX_LENGTH:
        raise ValueError("has numbers that are no position and no rotation")
    rotation = (turn.x / length, turn.y / length, turn.z / length, turn.w / length)
    return Transform((shift.x, shift.y, shift.z), rotation)
