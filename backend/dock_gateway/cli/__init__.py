"""The command line: `dock-gateway up`, `serve`, and a client of a running gateway."""

import click

from dock_gateway import __version__
from dock_gateway.cli.client import battery, cancel, dock, release, stop, undock, watch
from dock_gateway.cli.serve import openapi, serve
from dock_gateway.cli.up import up


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__)
def main() -> None:
    """Drive ROS 2 actions from a browser, curl or a WebSocket."""


for command in (up, serve, dock, undock, cancel, stop, release, watch, battery, openapi):
    main.add_command(command)
