"""The ROS interface packages on this machine: their names, Python classes and definition files.

Type names come from clients and from any node on the ROS graph. Importing a Python package runs it, so only packages
that rosidl generated are imported by name.
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
_SERVICE_TYPE = re.compile(f"({PACKAGE_NAME})/srv/({TYPE_NAME})")
_INDEX = Path("share/ament_index/resource_index/rosidl_interfaces")


def full_type(name: str, kind: str = "msg") -> str:
    """Return `std_msgs/msg/String` for `std_msgs/String`, too."""
    package, separator, rest = name.partition("/")
    return name if not separator or "/" in rest else f"{package}/{kind}/{rest}"


def load_action(type_name: str) -> Any:
    """Import the Python class of an action type such as `action_tutorials_interfaces/action/Fibonacci`.

    Raises:
        ImportError: The name is not an action type, the package is not installed, or it has no such action.
    """
    package, name = _split(_ACTION_TYPE, type_name, "an action type such as package/action/Name")
    action = _load(package, "action", name)
    if not all(hasattr(action, part) for part in ("Goal", "Result", "Feedback", "Impl")):
        raise ImportError(f"the ROS interfaces {package} have no action {name}")
    return action


def load_message(type_name: str) -> Any:
    """Import the Python class of a message type such as `sensor_msgs/msg/BatteryState`.

    The feedback of an action has its own type, `package/action/Name_FeedbackMessage`.

    Raises:
        ImportError: The name is not a message type, the package is not installed, or it has no such message.
    """
    package, name, action = _split(_MESSAGE_TYPE, type_name, "a message type such as package/msg/Name")
    if action:
        return load_action(f"{package}/action/{action}").Impl.FeedbackMessage
    message = _load(package, "msg", name)
    if not hasattr(message, "get_fields_and_field_types"):
        raise ImportError(f"the ROS interfaces {package} have no message {name}")
    return message


def load_service(type_name: str) -> Any:
    """Import the Python class of a service type such as `std_srvs/srv/Trigger`.

    Raises:
        ImportError: The name is not a service type, the package is not installed, or it has no such service.
    """
    package, name = _split(_SERVICE_TYPE, type_name, "a service type such as package/srv/Name")
    service = _load(package, "srv", name)
    if not (hasattr(service, "Request") and hasattr(service, "Response")):
        raise ImportError(f"the ROS interfaces {package} have no service {name}")
    return service


def _split(pattern: re.Pattern[str], type_name: str, what: str) -> tuple[str, ...]:
    if not (match := pattern.fullmatch(type_name)):
        raise ImportError(f"{type_name[:200]!r} is not {what}")
    return match.groups()


def _load(package: str, kind: str, name: str) -> Any:
    if not is_installed(package):
        raise ImportError(f"{package} is not installed: {install_hint(package)}")
    module = f"{package}.{kind}"
    try:
        # rclpy imports it when it uses the type, too late for an answer.
        importlib.import_module(f"{package}.{package}_s__rosidl_typesupport_c")
        return getattr(importlib.import_module(module), name, None)
    except ModuleNotFoundError as error:
        if error.name == module:
            return None
        raise
    except (Exception, SystemExit) as error:
        raise ImportError(f"{module} cannot be imported: {error!r}") from error


def is_installed(package: str) -> bool:
    """Return whether the package is installed and rosidl generated it, without importing it."""
    if not re.fullmatch(PACKAGE_NAME, package):
        return False
    try:
        spec = importlib.util.find_spec(package)
    except ValueError:
        return False
    folders = (spec.submodule_search_locations if spec else None) or ()
    return any(next(Path(folder).glob(f"{package}_s__rosidl_typesupport_c*"), None) for folder in folders)


def install_hint(package: str) -> str:
    """Return what to do if a package is missing."""
    wheel = f"ros-{os.environ.get('ROS_DISTRO', 'jazzy')}-{package.replace('_', '-')}"
    return f"install the Python package of the ROS interfaces {package} (such as {wheel})"


def known_actions() -> list[str]:
    """Return all action types in the ament index, sorted."""
    found = set()
    for prefix in install_prefixes():
        for entry in prefix.joinpath(_INDEX).glob("*"):
            for line in entry.read_text(errors="replace").splitlines():
                kind, _, file = line.partition("/")
                type_name = f"{entry.name}/action/{Path(file).stem}"
                if kind == "action" and _ACTION_TYPE.fullmatch(type_name):
                    found.add(type_name)
    return sorted(found)


@cache
def definition_text(package: str, kind: str, name: str) -> str | None:
    """Return the text of a definition file such as share/sensor_msgs/msg/BatteryState.msg, None without the file.

    Args:
        package: Such as `sensor_msgs`.
        kind: `msg`, `srv` or `action`.
        name: Such as `BatteryState`.
    """
    for prefix in install_prefixes():
        try:
            return prefix.joinpath("share", package, kind, f"{name}.{kind}").read_text(errors="replace")
        except OSError:
            continue
    return None


def install_prefixes() -> list[Path]:
    """Return the install prefixes: the sourced workspaces, then this environment, where wheels put their share/."""
    sourced = os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)
    return [Path(prefix) for prefix in dict.fromkeys([*sourced, sys.prefix]) if prefix]
