"""The common part of the commands that ask a running gateway: its address, the token, and how answers are printed."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import click

from dock_gateway.cli.shared_options import json_option, url_option
from dock_gateway.cli.stored_tokens import stored_token
from dock_gateway.client import Client, ClientError, GatewayUnreachable
from dock_gateway.core.log_config import printable

Command = Callable[..., Any]


robot_option = click.option("--robot", metavar="NAME", help="Namespace of the robot, such as /robot1.")


def asks(command: Command) -> Command:
    """Add the options of a command that asks a gateway."""
    return url_option(json_option(command))


def for_robot(command: Command) -> Command:
    """Add the robot, as an argument or as an option. It arrives as `robot`."""
    command = click.argument("name", metavar="[ROBOT]", required=False)(command)
    return robot_option(command)


def one_robot(name: str | None, robot: str | None) -> str | None:
    """Return the robot that a command names.

    Raises:
        click.UsageError: It names two.
    """
    if name is not None and robot is not None and name != robot:
        raise click.UsageError(f"both {name} and {robot} are named")
    return name or robot


def wanted(name: str) -> Any:
    """Return an option that may stand before or after the command: `url` or `as_json`; None if it is not given."""
    return click.get_current_context().find_root().ensure_object(dict).get(name)


@contextmanager
def gateway(*, timeout: float = 15.0) -> Iterator[Client]:
    """A client of the gateway that is meant, whose errors end the command with one sentence.

    The token is that in DOCK_GATEWAY_TOKEN, or else the one that `dock-gateway login` has stored for this address.
    There is no option for it, because other users of the machine can read command lines.

    Raises:
        click.ClickException: The gateway does not answer, or refuses. The message says why.
    """
    url = wanted("url")
    try:
        with Client(url, token=stored_token(url), timeout=timeout) as client:
            yield client
    except GatewayUnreachable as error:
        hint = "start one with `dock-gateway up`, or name another with --url or DOCK_GATEWAY_URL"
        raise click.ClickException(f"{error}; {hint}") from None
    except ClientError as error:
        hint = "; `dock-gateway login` stores a token" if getattr(error, "status", None) == 401 else ""
        raise click.ClickException(printable(f"{error}{hint}")) from None


def print_json(document: object) -> None:
    """Print a document, or what is like one."""
    from dock_gateway.core.goal import encode  # noqa: PLC0415 - not before a stop

    click.echo(encode(document))


def print_answer(document: object, line: str) -> None:
    """Print a document as JSON where that is wanted, else a line that says the same to people."""
    if wanted("as_json"):
        print_json(document)
    else:
        click.echo(printable(line))


def print_table(columns: tuple[str, ...], rows: Sequence[tuple[str, ...]], none: str) -> None:
    """Print lines with columns of one width.

    Args:
        columns: The headings.
        rows: The lines.
        none: Is printed if there are none.
    """
    if not rows:
        click.echo(none)
        return
    cells = [columns, *(tuple(map(printable, row)) for row in rows)]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    for row in cells:
        click.echo("  ".join(map(str.ljust, row, widths)).rstrip())
