"""`dock-gateway serve`: the gateway alone.

The server takes seconds to import. It is imported where it runs, so that client commands do not wait for it.
"""

import os
from functools import partial
from typing import Any

import click

from dock_gateway.cli.options import TYPE, SettingsCommand, read_again, read_settings, settings_options
from dock_gateway.cli.start import check_start, load_ros

# What the variables begin with that ROS and DDS read.
ROS_PREFIXES = ("ROS_", "RMW_", "FASTDDS_", "FASTRTPS_", "CYCLONEDDS_", "ZENOH_")


@click.command(cls=SettingsCommand)
@settings_options
def serve(**options: Any) -> None:
    """Run only the gateway, for action servers that run already."""
    settings = read_settings(options)
    check_start(settings, os.environ)
    load_ros(os.environ)
    from dock_gateway.cli.gateway import run_gateway  # noqa: PLC0415
    from dock_gateway.core.errors import GatewayError  # noqa: PLC0415
    from dock_gateway.http.edge.certificates import CertificateError  # noqa: PLC0415 - see above

    variables = " ".join(sorted(name for name in os.environ if name.startswith(ROS_PREFIXES)))
    try:
        started = run_gateway(settings, partial(read_again, TYPE, options))
    except CertificateError as error:
        raise click.UsageError(str(error)) from None
    except GatewayError as error:
        advice = "" if error.code == "robots_claimed" else f"; check {variables or 'the network'}"
        raise click.ClickException(f"{error.detail}{advice}") from None
    if not started:
        raise SystemExit(1)
