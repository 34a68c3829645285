"""The command line: `up`, `serve`, `doctor`, `user`, `token` and others, and a client of a running gateway."""

import gc
import importlib
from collections.abc import Iterator
from functools import cached_property
from importlib.metadata import EntryPoint, entry_points

import click

from dock_gateway import __version__
from dock_gateway.cli.groups import WHOLE
from dock_gateway.cli.shared_options import json_option, url_option

# The commands in the order of the help, by heading, and the modules that they are in.
SECTIONS: dict[str, dict[str, str]] = {
    "Run a gateway": {"up": "up", "serve": "serve", "doctor": "doctor", "config": "config", "service": "service"},
    "Stop robots": {"stop": "stop", "release": "stop"},
    "Move robots, and see what they do": {
        "dock": "goals",
        "undock": "goals",
        "send": "goals",
        "cancel": "goals",
        "watch": "goals",
        "goals": "goals",
        "goal": "goals",
        "robots": "overview",
        "docks": "overview",
        "alerts": "overview",
        "battery": "battery",
        "api": "api",
        "login": "login",
        "logout": "login",
    },
    "Users and tokens, in the database of a gateway": {"user": "user", "token": "token"},
    "Documents and recordings": {"schema": "schema", "replay": "replay"},
}
COMMANDS = {name: module for section in SECTIONS.values() for name, module in section.items()}
# The heading of commands of extensions and other programs.
FURTHER = "Further"

# The entry points of the commands of other programs.
GROUP = "dock_gateway.commands"


def modules_of(kind: str) -> Iterator[str]:
    """Yield the modules of one name that extensions have. Only few commands need to know the extensions."""
    from dock_gateway import extension_list  # noqa: PLC0415 - takes a tenth of a second

    return extension_list.modules_of(kind)


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
                command: click.Command = getattr(module, cmd_name)
                return command
            if (found := self._of_extensions.get(cmd_name)) is not None:
                return found
            return next((_load(entry) for entry in entry_points(group=GROUP, name=cmd_name)), None)
        finally:
            gc.enable()

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the command, and refuse options before it that it does not have."""
        name, command, rest = super().resolve_command(ctx, args)
        known = set() if command is None else {parameter.name for parameter in command.params}
        for option in ctx.obj or ():
            if command is not None and option not in known:
                raise click.UsageError(f"{name} asks no gateway: leave out --{option.removeprefix('as_')}")
        return name, command, rest

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the commands, each section with its heading."""
        placed = {name: heading for heading, names in SECTIONS.items() for name in names}
        sections: dict[str, list[tuple[str, str]]] = {heading: [] for heading in (*SECTIONS, FURTHER)}
        for name in self.list_commands(ctx):
            if (command := self.get_command(ctx, name)) is not None and not command.hidden:
                sections[placed.get(name, FURTHER)].append((name, command.get_short_help_str(WHOLE)))
        for heading, lines in sections.items():
            if lines:
                with formatter.section(heading):
                    formatter.write_dl(lines)

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
@url_option
@json_option
def main() -> None:
    """Drive ROS 2 actions from a browser, curl or a WebSocket.

    --url and --json may stand before or after the commands that ask a gateway.
    """
