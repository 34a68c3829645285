"""Takes std_msgs/Bool messages with the id of their publisher, which this rclpy does not tell."""

import ctypes
from typing import NamedTuple

from rclpy.subscription import Subscription


class _MessageInfo(ctypes.Structure):
    """rmw_message_info_t of ROS 2 Iron and later, with room for what a later one may add."""

    _fields_ = (
        ("source_timestamp", ctypes.c_int64),
        ("received_timestamp", ctypes.c_int64),
        ("publication_sequence_number", ctypes.c_uint64),
        ("reception_sequence_number", ctypes.c_uint64),
        ("implementation_identifier", ctypes.c_char_p),
        ("gid", ctypes.c_uint8 * 16),
        ("from_intra_process", ctypes.c_bool),
        ("room", ctypes.c_uint8 * 64),
    )


class Taken(NamedTuple):
    """A message: what it says, its number, its source timestamp in ns, and its publisher's `endpoint_gid`."""

    data: bool
    number: int
    stamp_ns: int
    publisher: bytes


_rcl_take = ctypes.CDLL("librcl.so").rcl_take
_rcl_take.argtypes = [ctypes.c_void_p] * 4
_rcl_take.restype = ctypes.c_int


def take_bool(subscription: Subscription) -> Taken | None:
    """Take the next message of a subscription to std_msgs/Bool; None if there is none.

    Raises:
        InvalidHandle: The subscription was destroyed.
    """
    data, info = ctypes.c_bool(), _MessageInfo()
    with subscription.handle:
        failed = _rcl_take(subscription.handle.pointer, ctypes.byref(data), ctypes.byref(info), None)
    if failed:
        return None
    return Taken(data.value, info.publication_sequence_number, info.source_timestamp, bytes(info.gid))
