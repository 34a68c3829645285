"""`dock-gateway token create`, `list`, `revoke`: tokens of those who use the gateway.

They are read and written in the history's database, whether a gateway runs or not: the first token of an admin is
created here. A running gateway knows them 2 s later.
"""

import asyncio
from collections.abc import Awaitable, Callable
from datetime import timedelta
from typing import Any

import click

from dock_gateway.cli.options import read_settings
from dock_gateway.core.errors import GatewayError
from dock_gateway.core.event import utc_now
from dock_gateway.core.grant import LIMITS, PATTERN, Grant, Role

database_option = click.option(
    "--database-url", envvar="DOCK_GATEWAY_DATABASE_URL", show_envvar=True, help="The gateway's database."
)


def limit_option(flag: str, name: str, what: str) -> Callable[[Any], Any]:
    """Return an option that limits what a token is for. It may be repeated."""

    def check(_: click.Context, __: click.Parameter, patterns: tuple[str, ...]) -> tuple[str, ...]:
        for pattern in patterns:
            if not PATTERN.fullmatch(pattern):
                raise click.BadParameter(f"{pattern!r} is not a name, with * for any text")
        return patterns

    usage = f"Only these {what}; may be repeated."
    return click.option(flag, name, multiple=True, metavar="PATTERN", callback=check, help=usage)


def with_tokens(database_url: str | None, use: Callable[[Any], Awaitable[Any]]) -> Any:
    """Open the tokens, use them, and return what that returns.

    Raises:
        click.ClickException: The database does not answer, or refuses. The message says why.
    """
    from dock_gateway.access.tokens import MAX_TOKENS, Tokens  # noqa: PLC0415 - takes a second
    from dock_gateway.fleet.shared_book import SharedBook  # noqa: PLC0415
    from dock_gateway.history import open_history  # noqa: PLC0415

    settings = read_settings({"database_url": database_url})
    if settings.database_url == "memory:":
        raise click.UsageError("the history `memory:` keeps no tokens: name a database with --database-url")

    async def run() -> Any:
        async with open_history(settings) as history:
            return await use(Tokens(SharedBook(history.tokens, "token", MAX_TOKENS)))

    try:
        return asyncio.run(run())
    except GatewayError as error:
        raise click.ClickException(f"{error.code}: {error.detail}") from None


@click.group()
def token() -> None:
    """Create, list and revoke tokens."""


@token.command()
@click.argument("name")
@click.option("--role", type=click.Choice([role.value for role in Role]), default=Role.VIEWER.value, show_default=True)
@click.option("--days", type=click.IntRange(1, 3650), help="For how long it is valid.  [default: until it is revoked]")
@limit_option("--robot", "robots", "robots, such as /robot1 or /hall_a/*")
@limit_option("--action", "actions", "actions, such as */connect_to_charging_dock")
@limit_option("--topic", "topics", "topics, such as */battery_status")
@database_option
def create(name: str, role: str, days: int | None, database_url: str | None, **limits: tuple[str, ...]) -> None:
    """Create a token for NAME, and print its secret, which is not stored."""
    expires_at = None if days is None else utc_now() + timedelta(days=days)
    grant = Grant(Role(role), **limits)
    if grant.role is Role.ADMIN and grant != Grant(Role.ADMIN):
        raise click.UsageError("an admin cannot be limited, as an admin can change any limit")
    _, secret = with_tokens(database_url, lambda tokens: tokens.create(name, grant, expires_at))
    click.echo(secret)


@token.command(name="list")
@database_option
def list_tokens(database_url: str | None) -> None:
    """List all tokens."""
    for each in with_tokens(database_url, lambda tokens: tokens.documents()):
        expires = "" if each["expires_at"] is None else f", until {each['expires_at']:%Y-%m-%d %H:%M} UTC"
        used = "never used" if each["used_at"] is None else f"used {each['used_at']:%Y-%m-%d %H:%M} UTC"
        state = "" if each["valid"] else ", expired"
        limits = "".join(f", only {noun} {' '.join(each[noun])}" for noun in LIMITS if each[noun])
        click.echo(f"{each['id']}  {each['role']:10}  {each['name']}  ({used}{expires}{state}{limits})")


@token.command()
@click.argument("name")
@database_option
def revoke(name: str, database_url: str | None) -> None:
    """Revoke the token with this NAME or id."""

    async def find_and_revoke(tokens: Any) -> None:
        found = [each["id"] for each in await tokens.documents() if name in (each["id"], each["name"])]
        if not found:
            raise click.ClickException(f"there is no token {name}")
        await tokens.revoke(found[0])

    with_tokens(database_url, find_and_revoke)
