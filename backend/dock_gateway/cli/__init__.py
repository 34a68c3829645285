"""The command line: `up`, `serve`, `doctor`, `user`, `token` and others, and a client of a running gateway."""

import gc
import importlib
from importlib.metadata import EntryPoints, entry_points

import click

from dock_gateway import __version__
from dock_gateway.extension_list import modules_of

COMMANDS = {
    "up": "up",
    "serve": "serve",
    "doctor": "doctor",
    "install-service": "install_service",
    "dock": "client",
    "undock": "client",
    "cancel": "client",
    "stop": "client",
    "release": "client",
    "watch": "client",
    "battery": "client",
    "user": "user",
    "token": "token",
    "replay": "replay",
    "openapi": "documents",
    "asyncapi": "documents",
}
"""The commands, in the order of the help, and the modules that they are in."""


class LazyGroup(click.Group):
    """Loads only the command that is called, so that a server does not load an HTTP client before it starts.

    An extension adds those of its module `commands`; other programs add commands by their entry points, in the group
    `dock_gateway.commands`.
    """

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names of all commands."""
        return [*COMMANDS, *_of_extensions(), *sorted(_others().names)]

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Load and return a command."""
        gc.disable()  # loaded modules stay
        try:
            if cmd_name in COMMANDS:
                module = importlib.import_module(f"dock_gateway.cli.{COMMANDS[cmd_name]}")
                command: click.Command = getattr(module, cmd_name.replace("-", "_"))
                return command
            if (found := _of_extensions().get(cmd_name)) is not None:
                return found
            return next((entry.load() for entry in _others().select(name=cmd_name)), None)
        finally:
            gc.enable()


def _of_extensions() -> dict[str, click.Command]:
    modules = [importlib.import_module(name) for name in modules_of("commands")]
    return {command.name: command for module in modules for command in module.COMMANDS}


def _others() -> EntryPoints:
    return entry_points(group="dock_gateway.commands")


@click.group(cls=LazyGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__)
def main() -> None:
    """Drive ROS 2 actions from a browser, curl or a WebSocket."""
