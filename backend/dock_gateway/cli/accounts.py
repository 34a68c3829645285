"""Users and tokens in the history's database, for the commands that change them whether a gateway runs or not."""

import asyncio
from collections.abc import Awaitable, Callable
from typing import Any

import click

from dock_gateway.cli.databases import Choice
from dock_gateway.cli.options import config_option, read_settings
from dock_gateway.core.errors import GatewayError
from dock_gateway.core.grant import LIMITS, Grant, Role
from dock_gateway.setting_types import PATTERN

Command = Callable[..., Any]

_database_url = click.option(
    "--database-url", envvar="DOCK_GATEWAY_DATABASE_URL", show_envvar=True, help="The gateway's database."
)


def database_option(command: Command) -> Command:
    """Add the database, and the configuration file that may name it."""
    return config_option(_database_url(command))


def grant_options(command: Command) -> Command:
    """Add the options of a grant. They arrive as `role`, `robots`, `actions` and `topics`."""
    for decorate in (
        _limit_option("--topic", "topics", "topics, such as */battery_status"),
        _limit_option("--action", "actions", "actions, such as */connect_to_charging_dock"),
        _limit_option("--robot", "robots", "robots, such as /robot1 or /hall_a/*"),
        click.option(
            "--role", type=click.Choice([role.value for role in Role]), default=Role.VIEWER.value, show_default=True
        ),
    ):
        command = decorate(command)
    return command


def _limit_option(flag: str, name: str, what: str) -> Callable[[Command], Command]:
    def check(_: click.Context, __: click.Parameter, patterns: tuple[str, ...]) -> tuple[str, ...]:
        for pattern in patterns:
            if not PATTERN.fullmatch(pattern):
                raise click.BadParameter(f"{pattern!r} is not a name, with * for any text")
        return patterns

    usage = f"Only these {what}; may be repeated."
    return click.option(flag, name, multiple=True, metavar="PATTERN", callback=check, help=usage)


def make_grant(role: str, limits: dict[str, tuple[str, ...]]) -> Grant:
    """Return the grant that options name.

    Raises:
        click.UsageError: It limits an admin.
    """
    grant = Grant(Role(role), *(limits[name] for name in LIMITS))
    if grant.role is Role.ADMIN and grant != Grant(Role.ADMIN):
        raise click.UsageError("an admin cannot be limited, as an admin can change any limit")
    return grant


def describe_limits(document: dict[str, Any]) -> str:
    """Return the limits of a user or a token in words; empty if there are none."""
    return "".join(f", only {noun} {' '.join(document[noun])}" for noun in LIMITS if document[noun])


def with_logins(database_url: str | None, use: Callable[[Any], Awaitable[Any]], *, changed: bool = True) -> Any:
    """Open the users and tokens, use them, say in which database they are, and return what that returns.

    Args:
        database_url: The gateway's database; None: that of the environment.
        use: Uses them.
        changed: Whether that changes them.

    Raises:
        click.ClickException: The database does not answer, or refuses. The message says why.
    """
    from dock_gateway.access.logins import Logins  # noqa: PLC0415 - takes a second
    from dock_gateway.storage import open_history  # noqa: PLC0415

    settings = read_settings({"database_url": database_url})
    if settings.database_url == "memory:":
        raise click.UsageError("the history `memory:` keeps no users or tokens: name a database with --database-url")

    async def run() -> Any:
        async with open_history(settings) as history:
            return await use(Logins(history))

    choice = Choice(settings)
    try:
        done = asyncio.run(run())
    except GatewayError as error:
        choice.report("looked")
        raise click.ClickException(f"{error.code}: {error.detail}") from None
    choice.report("stored" if changed else "read")
    return done
