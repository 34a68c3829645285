"""The ROS interface packages on this machine: which there are, their Python classes, their definition files.

Types come by name, from clients and from anybody on the ROS graph. Importing a Python package runs it, so nothing is
imported by name but packages that rosidl generated.
"""

import importlib
import importlib.util
import os
import re
import sys
from functools import cache
from pathlib import Path
from typing import Any

PACKAGE_NAME = r"[a-z][a-z0-9_]{0,99}"
TYPE_NAME = r"[A-Z][A-Za-z0-9]{0,99}"
_ACTION_TYPE = re.compile(f"({PACKAGE_NAME})/action/({TYPE_NAME})")
_MESSAGE_TYPE = re.compile(f"({PACKAGE_NAME})/(?:msg/({TYPE_NAME})|action/({TYPE_NAME})_FeedbackMessage)")
_INDEX = Path("share/ament_index/resource_index/rosidl_interfaces")


def load_action(type_name: str) -> Any:
    """The Python class of an action type such as `action_tutorials_interfaces/action/Fibonacci`.

    Raises:
        ImportError: It is no such name, the package is not installed, or it has no such action.
    """
    match = _ACTION_TYPE.fullmatch(type_name)
    if not match:
        raise ImportError(f"{type_name[:200]!r} is not an action type such as package/action/Name")
    package, name = match.groups()
    action = _load(package, "action", name)
    if not all(hasattr(action, part) for part in ("Goal", "Result", "Feedback", "Impl")):
        raise ImportError(f"the ROS interfaces {package} have no action {name}")
    return action


def load_message(type_name: str) -> Any:
    """The Python class of the messages on a topic of a type such as `sensor_msgs/msg/BatteryState`.

    The feedback of actions has a type of its own, `package/action/Name_FeedbackMessage`.

    Raises:
        ImportError: It is no such name, the package is not installed, or it has no such message.
    """
    match = _MESSAGE_TYPE.fullmatch(type_name)
    if not match:
        raise ImportError(f"{type_name[:200]!r} is not a message type such as package/msg/Name")
    package, name, action = match.groups()
    if action:
        return load_action(f"{package}/action/{action}").Impl.FeedbackMessage
    message = _load(package, "msg", name)
    if not hasattr(message, "get_fields_and_field_types"):
        raise ImportError(f"the ROS interfaces {package} have no message {name}")
    return message


def _load(package: str, kind: str, name: str) -> Any:
    if not is_installed(package):
        raise ImportError(f"{package} is not installed: {install_hint(package)}")
    module = f"{package}.{kind}"
    try:
        return getattr(importlib.import_module(module), name, None)
    except ModuleNotFoundError as error:
        if error.name == module:
            return None
        raise
    except (Exception, SystemExit) as error:
        raise ImportError(f"{module} cannot be imported: {error!r}") from error


def is_installed(package: str) -> bool:
    """Whether this Python has the package, and rosidl generated it; it is not imported for that."""
    if not re.fullmatch(PACKAGE_NAME, package):
        return False
    try:
        spec = importlib.util.find_spec(package)
    except ValueError:
        return False
    folders = (spec.submodule_search_locations if spec else None) or ()
    return any(next(Path(folder).glob(f"{package}_s__rosidl_typesupport_c*"), None) for folder in folders)


def install_hint(package: str) -> str:
    """What to do where a package is missing."""
    wheel = f"ros-{os.environ.get('ROS_DISTRO', 'jazzy')}-{package.replace('_', '-')}"
    return f"install the Python package of the ROS interfaces {package} (such as {wheel})"


def known_actions() -> list[str]:
    """The types of all actions that the ament index lists, sorted."""
    found = set()
    for prefix in _prefixes():
        for entry in prefix.joinpath(_INDEX).glob("*"):
            for line in entry.read_text(errors="replace").splitlines():
                kind, _, file = line.partition("/")
                type_name = f"{entry.name}/action/{Path(file).stem}"
                if kind == "action" and _ACTION_TYPE.fullmatch(type_name):
                    found.add(type_name)
    return sorted(found)


@cache
def definition_text(package: str, kind: str, name: str) -> str | None:
    """The definition as its author wrote it, such as share/sensor_msgs/msg/BatteryState.msg; None without the file.

    Args:
        package: Such as `sensor_msgs`.
        kind: `msg`, `srv` or `action`.
        name: Such as `BatteryState`.
    """
    for prefix in _prefixes():
        try:
            return prefix.joinpath("share", package, kind, f"{name}.{kind}").read_text(errors="replace")
        except OSError:
            continue
    return None


def _prefixes() -> list[Path]:
    """Where packages are: the sourced workspaces, then this environment, where wheels put their share/."""
    sourced = os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)
    return [Path(prefix) for prefix in dict.fromkeys([*sourced, sys.prefix]) if prefix]
