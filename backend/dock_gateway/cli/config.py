"""`dock-gateway config show` and `config check`: the settings that a gateway would have, and where they come from."""

import os
import re
from collections.abc import Mapping
from typing import Any

import click
import orjson
from pydantic import SecretStr

from dock_gateway.cli.groups import CommandGroup
from dock_gateway.cli.options import (
    TYPE,
    SettingsCommand,
    fields_of,
    option_name,
    read_settings,
    settings_options,
)
from dock_gateway.core.log_config import printable
from dock_gateway.setting_groups.group import PREFIX, config_file, read_file
from dock_gateway.settings import Settings, unknown_variables

HIDDEN = "********"
# The password in an address.
PASSWORD = re.compile(r"(?<=:)[^:@/]+(?=@)")


@click.group(cls=CommandGroup)
def config() -> None:
    """Show and check the settings that a gateway would have."""


@config.command(cls=SettingsCommand)
@click.option("--all", "with_defaults", is_flag=True, help="Show every setting, also with its default.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON document.")
@settings_options
def show(with_defaults: bool, as_json: bool, **options: Any) -> None:
    """Show each setting that has not its default: its value, and where it comes from. Secrets are hidden.

    It takes the options of `serve`.
    """
    settings = read_settings(options)
    found = _describe(settings, options)
    if not with_defaults:
        found = {name: each for name, each in found.items() if each["source"] != "default"}
    if as_json:
        click.echo(orjson.dumps(found, option=orjson.OPT_INDENT_2))
        return
    for name, each in found.items():
        value = each["value"]
        text = value if isinstance(value, str) else orjson.dumps(value).decode()
        click.echo(printable(f"{name} = {text}  ({each['source']})"))
    if not found:
        click.echo("every setting has its default")


@config.command(cls=SettingsCommand)
@settings_options
def check(**options: Any) -> None:
    """Check the settings as a start does, without one: values, files that they name, variables that are no settings.

    It takes the options of `serve`. The exit code is 1 if something is wrong.
    """
    from dock_gateway.cli.start import check_settings  # noqa: PLC0415 - only here

    check_settings(read_settings(options))
    if sentences := unknown_variables(os.environ, TYPE.model_fields):
        raise click.ClickException("; ".join(sentences))
    path = config_file()
    click.echo("the settings are valid" + ("" if path is None else f", those of {path}, too"))


def _describe(settings: Settings, options: Mapping[str, object]) -> dict[str, dict[str, Any]]:
    """Return the value and the source of each setting, by name."""
    path = config_file()
    in_file = {} if path is None else read_file(path)
    variables = {name.upper() for name in os.environ}

    def source(name: str) -> str:
        if options.get(name) is not None:
            return f"option {option_name(name)}"
        if f"{PREFIX}{name.upper()}" in variables:
            return f"variable {PREFIX}{name.upper()}"
        return f"file {path}" if name in in_file else "default"

    return {
        name: {"value": _shown(getattr(settings, name)), "source": source(name)}
        for name, _ in fields_of(type(settings))
    }


def _shown(value: object) -> object:
    """Return a value without its secrets, as JSON has it."""
    if isinstance(value, SecretStr):
        return HIDDEN
    if isinstance(value, dict):
        return {name: table.model_dump(exclude_defaults=True) for name, table in value.items()}
    if isinstance(value, tuple):
        return [PASSWORD.sub(HIDDEN, str(part)) for part in value]
    return value if isinstance(value, bool | int | float | None) else PASSWORD.sub(HIDDEN, str(value))
