"""Command-line options for settings: one for each field of `Settings` and of the settings of extensions."""

import os
import posixpath
import re
from collections.abc import Callable, Collection, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar, cast

import click
from pydantic import ValidationError
from pydantic.fields import FieldInfo

from dock_gateway.cli.groups import CommandGroup
from dock_gateway.extension_list import settings_type
from dock_gateway.setting_groups.group import CONFIG, PREFIX, SettingsGroup
from dock_gateway.setting_types import Tuning
from dock_gateway.settings import WITHOUT_OPTION, Settings, find_file_fault

TYPE = settings_type()
S = TypeVar("S", bound=Settings)
Command = Callable[..., Any]
# A link of Markdown.
LINK = re.compile(r"\[([^]]+)\]\(([^)#]+)[^)]*\)")


def groups_of(settings: type[Settings]) -> dict[str, list[tuple[str, FieldInfo]]]:
    """Return the settings with their fields, by the heading of their group; the gateway's own groups come first."""
    groups: dict[str, list[tuple[str, FieldInfo]]] = {}
    own = [kind for kind in reversed(Settings.__mro__) if issubclass(kind, SettingsGroup)]
    others = [kind for kind in reversed(settings.__mro__) if issubclass(kind, SettingsGroup) and kind not in own]
    placed: set[str] = set()
    for kind in (*own, *others):
        names = [name for name in kind.model_fields if name not in placed]
        if names:
            groups.setdefault(kind.group or "Further", []).extend((name, kind.model_fields[name]) for name in names)
            placed.update(names)
    return groups


def fields_of(settings: type[Settings]) -> list[tuple[str, FieldInfo]]:
    """Return all settings, in the order of the documentation."""
    return [field for group in groups_of(settings).values() for field in group]


# All settings of a gateway.
FIELDS = fields_of(TYPE)


def is_tuning(field: FieldInfo) -> bool:
    """Return whether a setting is one that no person needs."""
    return any(isinstance(mark, Tuning) for mark in field.metadata)


def option_name(field: str) -> str:
    """`server_wait` is `--server-wait`."""
    return f"--{field.replace('_', '-')}"


class SettingOption(click.Option):
    """The option of a setting.

    Attributes:
        group: The heading under which the help has it.
    """

    def __init__(self, names: Sequence[str], *, group: str, **attributes: Any) -> None:
        super().__init__(names, **attributes)
        self.group = group


class SettingsCommand(click.Command):
    """A command with settings, whose help has them in groups."""

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the options, each group with its heading."""
        _format_options(self, ctx, formatter)


class CommandsWithSettings(CommandGroup):
    """A command with settings that has further commands."""

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the options, each group with its heading, and the commands."""
        _format_options(self, ctx, formatter)
        self.format_commands(ctx, formatter)


def _format_options(command: click.Command, ctx: click.Context, formatter: click.HelpFormatter) -> None:
    sections: dict[str, list[tuple[str, str]]] = {"Options": []}
    for parameter in command.get_params(ctx):
        group = parameter.group if isinstance(parameter, SettingOption) else "Options"
        if (record := parameter.get_help_record(ctx)) is not None:
            sections.setdefault(group, []).append(record)
    for heading, records in sections.items():
        with formatter.section(heading):
            formatter.write_dl(records)


def _use_file(_: click.Context, __: click.Parameter, path: str | None) -> None:
    """Name the configuration file in the environment, where programs that this one starts find it, too."""
    if path is not None:
        os.environ[CONFIG] = str(Path(path).absolute())


config_option = click.option(
    "--config",
    metavar="FILE",
    expose_value=False,
    is_eager=True,
    callback=_use_file,
    help=f"Configuration file, in TOML.  [env: {CONFIG}]",
)


def settings_options(command: Command, leave_out: Collection[str] = (), settings: type[Settings] = TYPE) -> Command:
    """Add an option for each setting. They arrive as keyword arguments; those that are not given are None.

    Args:
        command: The command, a `SettingsCommand`.
        leave_out: Settings that only variables can set there.
        settings: The settings; by default, those of a gateway.
    """
    options = [
        _option(name, field, group)
        for group, fields in groups_of(settings).items()
        for name, field in fields
        if name not in leave_out and name not in WITHOUT_OPTION
    ]
    for names, attributes in reversed(options):
        command = click.option(*names, cls=SettingOption, **attributes)(command)
    return config_option(command)


def _option(name: str, field: FieldInfo, group: str) -> tuple[tuple[str, str], dict[str, Any]]:
    flag = field.annotation is bool
    default = describe_default(field.default)
    text = f"{plain(field.description or '')}  [env: {PREFIX}{name.upper()}{default and f'; default: {default}'}]"
    option = f"{option_name(name)}/--no-{option_name(name)[2:]}" if flag else option_name(name)
    kind: dict[str, Any] = {"is_flag": True, "default": None} if flag else {"metavar": "VALUE"}
    return (option, name), {"group": group, "help": text, "hidden": is_tuning(field), **kind}


def describe_default(default: object) -> str:
    """Return a default as a user writes it; empty if there is none."""
    if isinstance(default, bool):
        return str(default).lower()
    if isinstance(default, tuple):
        return ",".join(default)
    return str(default) if default not in (None, {}) else ""


def plain(text: str) -> str:
    """Return a description for a terminal: links of Markdown are the page's path, or their text."""

    def shown(link: re.Match[str]) -> str:
        return posixpath.join("docs", link[2]) if link[1].endswith(".md") else link[1]

    return LINK.sub(shown, text)


def arguments_of(options: Mapping[str, object]) -> list[str]:
    """Return the settings among the options of a command line again, as its arguments."""
    arguments = []
    for name, value in options.items():
        if isinstance(value, bool):
            arguments.append(option_name(name) if value else f"--no-{option_name(name)[2:]}")
        elif value is not None:
            arguments.append(f"{option_name(name)}={value}")
    return arguments


def read_settings(options: Mapping[str, object]) -> Settings:
    """Read the settings of a gateway from options, the environment, the file and defaults, in this order.

    Raises:
        click.UsageError: A value is invalid. The message says which.
    """
    return read_settings_of(TYPE, options)


def read_again(settings: type[S], options: Mapping[str, object]) -> S:
    """Read settings again while a program runs.

    Raises:
        ValueError: They are not valid. The message says why.
    """
    try:
        return read_settings_of(settings, options)
    except click.UsageError as error:
        raise ValueError(error.message) from None


def read_settings_of(settings: type[S], options: Mapping[str, object]) -> S:
    """Read settings from options, the environment, the file and defaults, in this order.

    Raises:
        click.UsageError: A value is invalid. The message says which.
    """
    given = cast("dict[str, Any]", {name: value for name, value in options.items() if value is not None})
    if (fault := find_file_fault(settings.model_fields)) is not None:
        raise click.UsageError(fault)
    try:
        return settings(**given)
    except ValidationError as error:
        lines = [
            f"{'.'.join(map(str, item['loc'])) or 'settings'}: {item['msg'].removeprefix('Value error, ')}"
            for item in error.errors()
        ]
        raise click.UsageError("; ".join(lines)) from None
