"""Finds what keeps ROS from starting: each fault is a sentence that says how to mend it."""

import importlib
from collections.abc import Iterable, Mapping

from robot_io import ros_variables
from robot_io.docking_messages import use_compiled
from robot_io.installation import (
    DOCKING,
    MESSAGES,
    SOURCED,
    find_installation,
    find_middleware_fault,
    find_mixture_fault,
    find_package_fault,
    find_setup,
    mend,
)


def find_start_fault(environment: Mapping[str, str]) -> str | None:
    """Return why no ROS node can start, and what to do; None if nothing is known to be wrong. Loads nothing of ROS."""
    for finding in ros_variables.check(environment):
        if finding.fatal:
            return finding.sentence
    return find_ros_fault(environment)


def find_ros_fault(environment: Mapping[str, str]) -> str | None:
    """Return what is wrong with the installed packages; None if nothing is known to be."""
    return find_package_fault(environment) or find_mixture_fault(environment) or find_middleware_fault(environment)


def find_docking_fault(environment: Mapping[str, str]) -> str | None:
    """Return why our docking actions cannot be used, and what to do; None if they can.

    Call it where `find_start_fault` found nothing. Where a sourced ROS lacks them, they are compiled, and this process
    starts again with them.
    """
    return use_compiled(environment) or find_package_fault(environment, [DOCKING])


def find_load_fault(environment: Mapping[str, str], packages: Iterable[str] = MESSAGES) -> str | None:
    """Load rclpy and packages of messages. Return why they do not fit each other, and what to do; None if they do."""
    package = "rclpy"
    try:
        from robot_io.rclpy_private import UnsupportedRclpyError, require_supported  # noqa: PLC0415 - takes a second

        for package in packages:
            importlib.import_module(f"{package}.{package}_s__rosidl_typesupport_c")
    except Exception as error:  # noqa: BLE001 - whatever is wrong in them
        why, advice = str(error).partition("\n")[0], mend(package, environment)
        installation = find_installation(environment)
        if installation is not None and not installation.wheels and "shared object" in why:
            advice = f"run `source {find_setup(package, installation)}`, or `unset {' '.join(SOURCED)}`"
        return f"the ROS package {package} does not load ({why}): {advice}"
    try:
        require_supported()
    except UnsupportedRclpyError as error:
        return str(error)
    return None
