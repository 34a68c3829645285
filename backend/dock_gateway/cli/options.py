"""Command-line options for settings: one for each field of `Settings` and of the settings of extensions."""

from collections.abc import Callable, Collection
from typing import Any, TypeVar

import click
from pydantic import ValidationError
from pydantic.fields import FieldInfo

from dock_gateway.extension_list import settings_type
from dock_gateway.settings import Settings

TYPE = settings_type()
# It says which options there are.
ONLY_A_VARIABLE = "extensions"
S = TypeVar("S", bound=Settings)


def fields_of(settings: type[Settings]) -> list[tuple[str, FieldInfo]]:
    """Return all settings, in the order of the documentation: the gateway's own come first."""
    return sorted(settings.model_fields.items(), key=lambda field: field[0] not in Settings.model_fields)


# All settings of a gateway.
FIELDS = fields_of(TYPE)

Command = Callable[..., Any]


def option_name(field: str) -> str:
    """`server_wait` is `--server-wait`."""
    return f"--{field.replace('_', '-')}"


def settings_options(command: Command, leave_out: Collection[str] = (), settings: type[Settings] = TYPE) -> Command:
    """Add an option for each setting. They arrive as keyword arguments; those that are not given are None.

    Args:
        command: The command.
        leave_out: Settings that only variables can set there.
        settings: The settings; by default, those of a gateway.
    """
    for name, field in reversed(fields_of(settings)):
        if name in leave_out or name == ONLY_A_VARIABLE:
            continue
        variable = f"DOCK_GATEWAY_{name.upper()}"
        default = ",".join(field.default) if isinstance(field.default, tuple) else field.default
        command = click.option(
            option_name(name),
            name,
            metavar="VALUE",
            help=f"{field.description}  [env: {variable}; default: {default}]",
        )(command)
    return command


def read_settings(options: dict[str, str | None]) -> Settings:
    """Read the settings of a gateway from options, the environment and defaults, in this order.

    Raises:
        click.UsageError: A value is invalid. The message says which.
    """
    return read_settings_of(TYPE, options)


def read_settings_of(settings: type[S], options: dict[str, str | None]) -> S:
    """Read settings from options, the environment and defaults, in this order.

    Raises:
        click.UsageError: A value is invalid. The message says which.
    """
    try:
        return settings(**{name: value for name, value in options.items() if value is not None})  # type: ignore[arg-type]
    except ValidationError as error:
        lines = [
            f"{'.'.join(map(str, item['loc'])) or 'settings'}: {item['msg'].removeprefix('Value error, ')}"
            for item in error.errors()
        ]
        raise click.UsageError("; ".join(lines)) from None
