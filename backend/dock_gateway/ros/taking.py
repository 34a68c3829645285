"""Takes messages with the id of their publisher, which this rclpy does not tell."""

import ctypes
from typing import Any, NamedTuple

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


class _Allocator(ctypes.Structure):
    """rcutils_allocator_t: four functions and their state."""

    _fields_ = tuple((name, ctypes.c_void_p) for name in ("allocate", "free", "grow", "zero", "state"))


class _Bytes(ctypes.Structure):
    """rcutils_uint8_array_t."""

    _fields_ = (
        ("buffer", ctypes.c_void_p),
        ("length", ctypes.c_size_t),
        ("capacity", ctypes.c_size_t),
        ("allocator", _Allocator),
    )


_rcl, _rcutils = ctypes.CDLL("librcl.so"), ctypes.CDLL("librcutils.so")
_rcl_take, _rcl_take_bytes = _rcl.rcl_take, _rcl.rcl_take_serialized_message
for _take in (_rcl_take, _rcl_take_bytes):
    _take.argtypes = [ctypes.c_void_p] * 4
    _take.restype = ctypes.c_int
_rcutils.rcutils_get_default_allocator.restype = _Allocator
_RCL_RET_OK, _RCL_RET_SUBSCRIPTION_TAKE_FAILED = 0, 401


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


class Buffer:
    """Takes encoded messages, one at a time, and copies only what is asked for. For one thread.

    Attributes:
        info: About the message: its `source_timestamp` in ns, and its `publisher`, an `endpoint_gid`.
    """

    def __init__(self) -> None:
        self.info: dict[str, Any] = {}
        self._info = _MessageInfo()
        self._bytes = _Bytes(allocator=_rcutils.rcutils_get_default_allocator())
        self._addresses = ctypes.addressof(self._bytes), ctypes.addressof(self._info)

    @property
    def size(self) -> int:
        """Size of the message in bytes."""
        return int(self._bytes.length)

    def take(self, subscription: Subscription) -> bool:
        """Take the next message of a subscription, whose handle the caller holds; return False if there is none.

        Raises:
            RuntimeError: ROS fails.
        """
        code = _rcl_take_bytes(subscription.handle.pointer, *self._addresses, None)
        if code == _RCL_RET_SUBSCRIPTION_TAKE_FAILED:
            return False
        if code != _RCL_RET_OK:
            _rcutils.rcutils_reset_error()
            raise RuntimeError(f"a message on {subscription.topic_name} could not be taken: rcl returned {code}")
        self.info = {"source_timestamp": self._info.source_timestamp, "publisher": bytes(self._info.gid)}
        return True

    def read(self, limit: int | None = None) -> bytes:
        """Return the message, or its first bytes."""
        size = self.size if limit is None else min(limit, self.size)
        return ctypes.string_at(self._bytes.buffer, size)
