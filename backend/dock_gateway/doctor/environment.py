"""Checks Python, the installed ROS and the variables of the environment."""

import platform
import sys
from collections.abc import Mapping
from importlib.metadata import distributions

from dock_gateway import __version__
from dock_gateway.core.dock_adapters.catalog import ADAPTERS
from dock_gateway.doctor.check import Check, Level, judge
from dock_gateway.settings import Settings, unknown_variables
from robot_io import ros_variables
from robot_io.installation import DOCKING, find_installation, find_package_fault
from robot_io.startup import find_load_fault, find_ros_fault

# The packages of the docking actions that can be used.
DOCKING_PACKAGES = tuple(dict.fromkeys(adapter.action_type.partition("/")[0] for adapter in ADAPTERS["dock"]))

# The distributions of the program. Each contains all modules that it needs.
DISTRIBUTIONS = ("dock-gateway", "dock-gateway-core", "dock-gateway-hub")


def check_environment(
    settings: Settings, environment: Mapping[str, str], docking_fault: str | None = None
) -> list[Check]:
    """Check Python, the settings, ROS and its variables.

    Args:
        settings: The settings.
        environment: The variables.
        docking_fault: Why our docking actions cannot be used, if that is known.
    """
    ros, docking = _check_ros(environment), check_docking(environment, docking_fault)
    if ros.level is Level.OK and (fault := find_load_fault(environment, _docking_packages(environment))):
        docking = Check("docking", Level.ERROR, fault)
    python = f"dock-gateway {__version__} on Python {platform.python_version()}, {sys.executable}"
    return [
        Check("python", Level.OK, python),
        check_settings(settings, environment),
        ros,
        docking,
        _check_domain(environment),
        _check_discovery(environment),
    ]


def check_settings(settings: Settings, environment: Mapping[str, str]) -> Check:
    """Check that the gateway may start with its settings, and that each variable is one."""
    if (fault := find_exposure_fault(settings)) is not None:
        return Check("settings", Level.ERROR, fault)
    unknown = ". ".join(unknown_variables(environment, type(settings).model_fields))
    given = sorted(settings.model_fields_set)
    found = f"{', '.join(given)} set, all others by default" if given else "all by default"
    return judge("settings", unknown or None, found, Level.WARNING)


def find_exposure_fault(settings: Settings) -> str | None:
    """Return that everyone on a network could move the robots, and what can be set instead; None if not."""
    if settings.open_to != "network" or settings.allow_open:
        return None
    return (
        f"on {settings.published_on or settings.host}, anyone who reaches this machine over the network could move "
        "the robots. Ask for a login with --authentication (docs/access.md), or accept that with "
        "--allow-open"
    )


def find_twin_fault() -> str | None:
    """Return that several distributions of the program are installed, which own the same files; None if one is."""
    found = [name for name in DISTRIBUTIONS if any(distributions(name=name))]
    if len(found) > 1:
        names = " ".join(found)
        return f"{' and '.join(found)} are installed together: run `pip uninstall {names}`, and install one of them"
    return None


def _check_ros(environment: Mapping[str, str]) -> Check:
    fault = find_ros_fault(environment) or find_load_fault(environment)
    return judge("ros", fault, "" if fault else describe_ros(environment))


def describe_ros(environment: Mapping[str, str]) -> str:
    """Return which ROS is loaded, with which RMW, and from where. `find_load_fault` must have found nothing."""
    from robot_io.participants import middleware  # noqa: PLC0415 - takes a second

    installation = find_installation(environment)
    if installation is None:
        raise LookupError("there is no rclpy")
    name = f"ROS 2 {installation.distribution.capitalize()}".rstrip()
    return f"{name} (rclpy {installation.version}) with {middleware()}, in {installation.source}"


def check_docking(environment: Mapping[str, str], fault: str | None) -> Check:
    """Check which docking actions can be used: one suffices, and the robots say which.

    Args:
        environment: The variables.
        fault: Why ours cannot be used, if that is known.
    """
    there = _docking_packages(environment)
    missing = [name for name in DOCKING_PACKAGES if name not in there]
    if not there:
        fault = fault or find_package_fault(environment, [DOCKING])
        return judge("docking", f"no docking action is installed: {fault}", "")
    absent = f"; not installed: {', '.join(missing)} (`make nav2-interfaces`, docs/nav2.md)" if missing else ""
    return Check("docking", Level.OK, f"the docking actions of {', '.join(there)} can be used{absent}")


def _docking_packages(environment: Mapping[str, str]) -> list[str]:
    """Return those of the docking actions that are installed."""
    return [name for name in DOCKING_PACKAGES if find_package_fault(environment, [name]) is None]


def _check_domain(environment: Mapping[str, str]) -> Check:
    for finding in ros_variables.check_domain(environment):
        return Check("domain", Level.ERROR if finding.fatal else Level.WARNING, finding.sentence)
    return Check("domain", Level.OK, f"ROS_DOMAIN_ID is {environment.get('ROS_DOMAIN_ID') or '0, as it is not set'}")


def _check_discovery(environment: Mapping[str, str]) -> Check:
    findings = ros_variables.check_discovery(environment)
    if findings:
        broken = any(each.fatal for each in findings) or ros_variables.sees_part_of_graph(environment)
        text = ". ".join(each.sentence for each in findings)
        return Check("discovery", Level.ERROR if broken else Level.WARNING, text)
    return Check("discovery", Level.OK, describe_discovery(environment))


def describe_discovery(environment: Mapping[str, str]) -> str:
    """Return where nodes are looked for."""
    if server := environment.get("ROS_DISCOVERY_SERVER", "").strip("; "):
        return f"nodes are found by the discovery server {server}"
    local = environment.get("ROS_LOCALHOST_ONLY") == "1"
    if local or environment.get("ROS_AUTOMATIC_DISCOVERY_RANGE") == "LOCALHOST":
        name = "ROS_LOCALHOST_ONLY" if local else "ROS_AUTOMATIC_DISCOVERY_RANGE"
        return f"only nodes on this machine are found, as {name} says"
    peers = environment.get("ROS_STATIC_PEERS", "")
    return f"nodes on the local network are found{f', and on {peers}' if peers else ''}"
