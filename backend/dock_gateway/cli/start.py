"""The checks of `serve` and `up` before anything starts: each fault is a sentence that says how to mend it."""

import importlib
import importlib.util
from collections.abc import Mapping

import click

from dock_gateway.doctor.check import Level
from dock_gateway.doctor.environment import check_docking, find_exposure_fault, find_twin_fault
from dock_gateway.doctor.machine import find_database_fault, find_port_fault
from dock_gateway.extension_list import extension_settings, missing_extension
from dock_gateway.settings import Settings
from robot_io.startup import find_docking_fault, find_load_fault, find_start_fault


def check_start(settings: Settings, environment: Mapping[str, str], *, docking: bool = False) -> None:
    """Refuse to start what cannot work.

    Args:
        settings: The settings.
        environment: The variables.
        docking: Whether our docking servers will be started, too.

    Raises:
        click.ClickException: The message says why, and what to do.
    """
    check_settings(settings)
    _refuse(find_twin_fault())
    check_ros(environment)
    _check_docking(environment, needed=docking)
    for setting in ("dock_action_type", "undock_action_type"):
        if action_type := getattr(settings, setting):
            check_installed(setting, action_type)
    check_port(settings)
    _refuse(find_database_fault(settings))


def check_settings(settings: Settings) -> None:
    """Refuse settings that do not fit each other, or name what is not there.

    Raises:
        click.UsageError: The message says why, and what to do.
    """
    if (fault := missing_extension()) is not None:
        raise click.UsageError(fault)
    check_exposure(settings)
    for kind in extension_settings():
        if (fault := kind.find_fault(settings.of(kind))) is not None:
            raise click.UsageError(fault)


def check_port(settings: Settings) -> None:
    """Refuse an address that cannot be listened on.

    Raises:
        click.ClickException: The message says why, and what to do.
    """
    _refuse(find_port_fault(settings))


def check_exposure(settings: Settings) -> None:
    """Refuse to let everyone on a network move the robots, unless `allow_open` allows it.

    Raises:
        click.UsageError: The message says what can be set instead.
    """
    if (fault := find_exposure_fault(settings)) is not None:
        raise click.UsageError(fault)


def check_ros(environment: Mapping[str, str]) -> None:
    """Refuse an environment in which no ROS node can start.

    Raises:
        click.ClickException: The message names the variable, or what is not installed.
    """
    _refuse(find_start_fault(environment))


def _check_docking(environment: Mapping[str, str], *, needed: bool) -> None:
    """Provide our docking actions. If that fails, refuse if they are needed, and say so if there are no others."""
    fault = find_docking_fault(environment)
    if needed:
        _refuse(fault)
    check = check_docking(environment, fault)
    if check.level is Level.ERROR:
        click.echo(f"dock-gateway: {check.text}", err=True)


def load_ros(environment: Mapping[str, str]) -> None:
    """Load rclpy and the messages.

    Raises:
        click.ClickException: They do not fit each other, or are not supported. The message says what to do.
    """
    _refuse(find_load_fault(environment))


def _refuse(fault: str | None) -> None:
    if fault is not None:
        raise click.ClickException(fault)


def check_installed(setting: str, action_type: str) -> None:
    """Refuse an action type that Python cannot import. Other actions on the graph may lack their packages.

    Raises:
        click.UsageError: The type is missing. The message names it.
    """
    package, _, name = action_type.split("/")
    try:
        found = hasattr(importlib.import_module(f"{package}.action"), name)
    except ModuleNotFoundError:
        found = False
    if not found:
        raise click.UsageError(f"{setting}: the ROS interfaces {package} with the action {name} are not installed")
