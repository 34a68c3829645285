"""Classes that stand in for messages whose package is not installed, so that their messages can at least be counted.

A subscription that takes bytes needs no more of a type than its name. Python's bindings ask for a compiled type
nevertheless, so one is made of `std_msgs/String`: its C structures are copied and given the other name. Nothing is ever
encoded or decoded with them. Only Fast DDS, whose structures these are, is served.
"""

import ctypes
import re
from ctypes import CFUNCTYPE, Structure, c_char_p, c_void_p
from functools import cache
from typing import Any

from rclpy.type_support import check_for_type_support
from rclpy.utilities import get_rmw_implementation_identifier
from std_msgs.msg import String

from dock_gateway.ros.types import MessageClass

RMW = "rmw_fastrtps_cpp"
TYPE_NAME = re.compile(r"\w+/\w+/\w+", re.ASCII)
FAST_DDS = b"rosidl_typesupport_fastrtps_c"


class _TypeSupport(Structure):
    """`rosidl_message_type_support_t` (rosidl_runtime_c)."""

    _fields_ = (
        ("identifier", c_char_p),
        ("data", c_void_p),
        ("find", c_void_p),
        ("get_type_hash", c_void_p),
        ("get_type_description", c_void_p),
        ("get_type_description_sources", c_void_p),
    )


class _Callbacks(Structure):
    """`message_type_support_callbacks_t` (rosidl_typesupport_fastrtps_cpp)."""

    _fields_ = (
        ("namespace", c_char_p),
        ("name", c_char_p),
        ("cdr_serialize", c_void_p),
        ("cdr_deserialize", c_void_p),
        ("get_serialized_size", c_void_p),
        ("max_serialized_size", c_void_p),
        ("key_callbacks", c_void_p),
    )


_Find = CFUNCTYPE(c_void_p, c_void_p, c_char_p)
_get_pointer = ctypes.pythonapi.PyCapsule_GetPointer
_get_pointer.restype, _get_pointer.argtypes = c_void_p, (ctypes.py_object, c_char_p)
_new_capsule = ctypes.pythonapi.PyCapsule_New
_new_capsule.restype, _new_capsule.argtypes = ctypes.py_object, (c_void_p, c_char_p, c_void_p)


@cache  # DDS keeps what it was given for as long as the process runs
def stand_in(type_name: str) -> MessageClass | None:
    """A class for raw subscriptions to a type such as `lift_msgs/msg/LiftState`; None where none can be made."""
    if get_rmw_implementation_identifier() != RMW or not TYPE_NAME.fullmatch(type_name):
        return None
    check_for_type_support(String)
    metaclass = type(String)
    address = _get_pointer(vars(metaclass)["_TYPE_SUPPORT"], None)
    original = _TypeSupport.from_address(address)
    find_original = _Find(original.find)
    found = find_original(address, FAST_DDS)
    if not found:
        return None
    package, kind, name = type_name.split("/")
    fast_dds = _TypeSupport.from_buffer_copy(_TypeSupport.from_address(found))
    callbacks = _Callbacks.from_buffer_copy(_Callbacks.from_address(fast_dds.data))
    callbacks.namespace, callbacks.name = f"{package}::{kind}".encode(), name.encode()
    fast_dds.data = ctypes.addressof(callbacks)

    def find(_: int, identifier: bytes) -> int | None:
        address_of_other: int | None = find_original(address, identifier)
        return ctypes.addressof(fast_dds) if identifier == FAST_DDS else address_of_other

    callback = _Find(find)
    support = _TypeSupport.from_buffer_copy(original)
    support.find = ctypes.cast(callback, c_void_p).value
    kept = (support, fast_dds, callbacks, callback, find_original)
    capsule = _new_capsule(ctypes.addressof(support), None, None)
    named: Any = type("StandInMetaclass", (metaclass,), {"_TYPE_SUPPORT": capsule, "kept": kept})
    return named("StandIn", (), {})
