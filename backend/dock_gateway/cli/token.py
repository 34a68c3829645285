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
from dock_gateway.core.access import Role
from dock_gateway.core.errors import GatewayError
from dock_gateway.core.event import utc_now

database_option = click.option(
    "--database-url", envvar="DOCK_GATEWAY_DATABASE_URL", show_envvar=True, help="The gateway's database."
)


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
@database_option
def create(name: str, role: str, days: int | None, database_url: str | None) -> None:
    """Create a token for NAME, and print its secret, which is not stored."""
    expires_at = None if days is None else utc_now() + timedelta(days=days)
    _, secret = with_tokens(database_url, lambda tokens: tokens.create(name, Role(role), expires_at))
    click.echo(secret)


@token.command(name="list")
@database_option
def list_tokens(database_url: str | None) -> None:
    """List all tokens."""
    for each in with_tokens(database_url, lambda tokens: tokens.documents()):
        expires = "" if each["expires_at"] is None else f", until {each['expires_at']:%Y-%m-%d %H:%M} UTC"
        used = "never used" if each["used_at"] is None else f"used {each['used_at']:%Y-%m-%d %H:%M} UTC"
        state = "" if each["valid"] else ", expired"
        click.echo(f"{each['id']}  {each['role']:10}  {each['name']}  ({used}{expires}{state})")


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
