"""The command line: `up`, `serve`, `doctor`, `user`, `token` and others, and a client of a running gateway."""

import gc
import importlib
from functools import cached_property
from importlib.metadata import EntryPoint, entry_points

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

# The entry points of the commands of other programs.
GROUP = "dock_gateway.commands"


class LazyGroup(click.Group):
    """Loads only the command that is called, so that a server does not load an HTTP client before it starts.

    An extension adds those of its module `commands`; other programs add commands by their entry points, in the group
    `dock_gateway.commands`. What cannot be imported is missing, and stderr says so.
    """

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names of all commands."""
        return [*COMMANDS, *self._of_extensions, *sorted(entry_points(group=GROUP).names)]

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Load and return a command."""
        gc.disable()  # loaded modules stay
        try:
            if cmd_name in COMMANDS:
                module = importlib.import_module(f"dock_gateway.cli.{COMMANDS[cmd_name]}")
                command: click.Command = getattr(module, cmd_name.replace("-", "_"))
                return command
            if (found := self._of_extensions.get(cmd_name)) is not None:
                return found
            return next((_load(entry) for entry in entry_points(group=GROUP, name=cmd_name)), None)
        finally:
            gc.enable()

    @cached_property
    def _of_extensions(self) -> dict[str, click.Command]:
        found: dict[str, click.Command] = {}
        for name in modules_of("commands"):
            try:
                found |= {command.name: command for command in importlib.import_module(name).COMMANDS}
            except Exception as error:  # noqa: BLE001 - said on stderr
                _say_missing(f"the commands of {name}", error)
        return found


def _load(entry: EntryPoint) -> click.Command | None:
    """Return the command of another program; None if it cannot be imported."""
    try:
        command: click.Command = entry.load()
    except Exception as error:  # noqa: BLE001 - said on stderr
        _say_missing(f"the command {entry.name}", error)
        return None
    return command


def _say_missing(what: str, error: Exception) -> None:
    click.echo(f"{what} cannot be imported: {type(error).__name__}: {error}", err=True)


@click.group(cls=LazyGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__)
def main() -> None:
    """Drive ROS 2 actions from a browser, curl or a WebSocket."""
