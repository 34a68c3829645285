"""The look-ups that ros2-http-gateway imports."""

from importlib import import_module
from typing import Any


def get_interface(name: str) -> Any:
    """The class of an interface, such as `std_msgs/msg/String`."""
    package, kind, interface = name.split("/")
    return getattr(import_module(f"{package}.{kind}"), interface)


get_action = get_message = get_service = get_interface
