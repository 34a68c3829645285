"""`dock-gateway serve`: the gateway alone; `dock-gateway openapi`: its OpenAPI document.

The server takes seconds to import. It is imported where it runs, so that client commands do not wait for it.
"""

import importlib
import os
from collections.abc import Mapping

import click
import orjson

from dock_gateway.cli.options import read_settings, settings_options
from dock_gateway.core import ros_variables
from dock_gateway.settings import Settings


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


def check_exposure(settings: Settings) -> None:
    """Refuse to let everyone on a network move the robots, unless `insecure_open` allows it.

    Raises:
        click.UsageError: The message says what can be set instead.
    """
    if settings.open_to == "network" and not settings.insecure_open:
        raise click.UsageError(
            f"on {settings.published_on or settings.host}, anyone who reaches this machine over the network could move "
            "the robots. Ask for a login with --authentication true (docs/access.md), or accept that with "
            "--insecure-open true"
        )


def check_ros(environment: Mapping[str, str]) -> None:
    """Refuse an environment in which no ROS node can start, and an rclpy that is not supported.

    Raises:
        click.UsageError: The message names the variable, or what rclpy lacks.
    """
    for finding in ros_variables.check(environment):
        if finding.fatal:
            raise click.UsageError(finding.sentence)
    from robot_io.rclpy_private import UnsupportedRclpyError, require_supported  # noqa: PLC0415 - see above

    try:
        require_supported()
    except UnsupportedRclpyError as error:
        raise click.UsageError(str(error)) from None


@click.command()
@settings_options
def serve(**options: str | None) -> None:
    """Run only the gateway, for action servers that run already."""
    settings = read_settings(options)
    for setting in ("dock_action_type", "undock_action_type"):
        if action_type := getattr(settings, setting):
            check_installed(setting, action_type)
    check_exposure(settings)
    check_ros(os.environ)
    from dock_gateway.cli.server import run  # noqa: PLC0415
    from dock_gateway.http.edge.certificates import CertificateError  # noqa: PLC0415 - see above

    try:
        started = run(settings)
    except CertificateError as error:
        raise click.UsageError(str(error)) from None
    if not started:
        raise SystemExit(1)


@click.command()
def openapi() -> None:
    """Print the OpenAPI document."""
    from dock_gateway.app import create_app  # noqa: PLC0415 - see above

    document = create_app(Settings()).openapi()
    click.echo(orjson.dumps(document, option=orjson.OPT_INDENT_2).decode())
