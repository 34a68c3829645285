"""`dock-gateway schema openapi` and `schema asyncapi`: the documents of the API."""

from importlib.metadata import entry_points
from typing import Any

import click
import orjson

from dock_gateway.cli.groups import CommandGroup
from dock_gateway.settings import Settings

# Applications of other programs, by name: each is a function that makes one.
OTHERS = entry_points(group="dock_gateway.applications")


def _flags(command: Any) -> Any:
    """Add a flag for each application of another program, with its name."""
    for name in sorted(OTHERS.names):
        command = click.option(f"--{name}", "other", flag_value=name, help=f"That of a {name}.")(command)
    return command


@click.group(cls=CommandGroup)
def schema() -> None:
    """Print the documents of the API."""


@schema.command()
@_flags
def openapi(other: str | None = None) -> None:
    """Print the OpenAPI document: requests and answers."""
    _print(_openapi() if other is None else OTHERS[other].load()().openapi())


@schema.command()
def asyncapi() -> None:
    """Print the AsyncAPI document: streams, and the commands of /ws."""
    document = _openapi()
    from dock_gateway.extension import extensions  # noqa: PLC0415 - takes seconds to import
    from dock_gateway.streams.asyncapi import asyncapi_document  # noqa: PLC0415 - as above

    _print(asyncapi_document(document, extensions().events))


def _openapi() -> dict[str, Any]:
    try:
        from dock_gateway.app import create_app  # noqa: PLC0415 - takes seconds to import
    except ModuleNotFoundError as error:
        raise click.ClickException(f"a gateway's documents describe ROS messages, which need ROS: {error}") from None
    return create_app(Settings()).openapi()


def _print(document: dict[str, Any]) -> None:
    click.echo(orjson.dumps(document, option=orjson.OPT_INDENT_2).decode())
