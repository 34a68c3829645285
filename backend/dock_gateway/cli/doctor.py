"""`dock-gateway doctor`: checks what a gateway needs, and says what to do."""

import os
import sys
from collections.abc import Iterator
from typing import Any

import click
import orjson

from dock_gateway.cli.options import SettingsCommand, read_settings, settings_options
from dock_gateway.core.log_config import printable
from dock_gateway.doctor.check import Check, Level
from dock_gateway.doctor.environment import check_environment
from dock_gateway.doctor.machine import check_machine
from dock_gateway.settings import Settings
from robot_io.startup import find_docking_fault, find_start_fault

COLORS = {Level.OK: "green", Level.WARNING: "yellow", Level.ERROR: "red"}
# The checks without which no node can join the graph.
VITAL = ("ros", "domain")


@click.command(cls=SettingsCommand)
@click.option("--json", "as_json", is_flag=True, help="Print one JSON document.")
@click.option(
    "--wait",
    "seconds",
    type=click.FloatRange(0.0, 60.0),
    default=4.0,
    show_default=True,
    help="Seconds to look at the ROS graph; 0: not at all.",
)
@settings_options
def doctor(as_json: bool, seconds: float, **options: Any) -> None:
    """Check the environment, this machine and the robots on the ROS graph, and say what to do.

    Nothing is published. It takes the settings of `serve`. The exit code is 1 if there is an error.
    """
    settings = read_settings(options)
    checks: list[Check] = []
    for check in _check(settings, seconds):
        checks.append(check)
        if not as_json:
            level = click.style(f"{check.level:7}", fg=COLORS[check.level])
            click.echo(f"{level}  {check.name}: {printable(check.text)}")
    healthy = all(check.level is not Level.ERROR for check in checks)
    lines = _settings_of(checks)
    if as_json:
        document = {"ok": healthy, "checks": [check.document() for check in checks], "settings": lines}
        click.echo(orjson.dumps(document, option=orjson.OPT_INDENT_2))
    elif lines:
        click.echo("\nSet this in the configuration file (--config gateway.toml), and start the gateway again:")
        for line in lines:
            click.echo(f"  {line}")
    sys.exit(0 if healthy else 1)


def _check(settings: Settings, seconds: float) -> Iterator[Check]:
    fault = None if find_start_fault(os.environ) else find_docking_fault(os.environ)
    environment = check_environment(settings, os.environ, fault)
    yield from environment
    yield from check_machine(settings)
    if not seconds or any(check.level is Level.ERROR and check.name in VITAL for check in environment):
        return
    from dock_gateway.core.errors import Unavailable  # noqa: PLC0415 - only where ROS works
    from dock_gateway.doctor.robots import RobotChecks  # noqa: PLC0415
    from dock_gateway.ros.snapshot import take_snapshot  # noqa: PLC0415

    try:
        snapshot = take_snapshot(settings, seconds)
    except Unavailable as error:
        yield Check("graph", Level.ERROR, error.detail)
    else:
        yield from RobotChecks(settings, snapshot, os.environ).all()


def _settings_of(checks: list[Check]) -> list[str]:
    from dock_gateway.doctor.robots import merge_settings  # noqa: PLC0415 - see above

    return merge_settings(checks)
