"""`dock-gateway token create`, `list`, `delete`: tokens of scripts and of those who log in without a password.

They are read and written in the history's database. A running gateway knows changes 2 s later.
"""

from datetime import timedelta
from typing import Any

import click

from dock_gateway.cli.accounts import database_option, describe_limits, grant_options, make_grant, with_logins
from dock_gateway.cli.groups import CommandGroup
from dock_gateway.core.errors import NotFound
from dock_gateway.core.event import utc_now


@click.group(cls=CommandGroup)
def token() -> None:
    """Create, list and delete tokens."""


@token.command()
@click.argument("name")
@grant_options
@click.option("--days", type=click.IntRange(1, 3650), help="For how long it is valid.  [default: until it is deleted]")
@database_option
def create(name: str, role: str, days: int | None, database_url: str | None, **limits: tuple[str, ...]) -> None:
    """Create a token for NAME, and print its secret, which is not stored."""
    expires_at = None if days is None else utc_now() + timedelta(days=days)
    grant = make_grant(role, limits)
    _, secret = with_logins(database_url, lambda logins: logins.create_token(name, grant, expires_at))
    click.echo(secret)


@token.command(name="list")
@database_option
def list_tokens(database_url: str | None) -> None:
    """List all tokens."""
    for each in with_logins(database_url, lambda logins: logins.tokens.documents(), changed=False):
        expires = "" if each["expires_at"] is None else f", until {each['expires_at']:%Y-%m-%d %H:%M} UTC"
        used = "never used" if each["used_at"] is None else f"used {each['used_at']:%Y-%m-%d %H:%M} UTC"
        state = "" if each["valid"] else ", expired"
        click.echo(f"{each['id']}  {each['role']:10}  {each['name']}  ({used}{expires}{state}{describe_limits(each)})")


@token.command()
@click.argument("name")
@database_option
def delete(name: str, database_url: str | None) -> None:
    """Delete the token with this NAME or id: it is valid no more."""

    async def find_and_delete(logins: Any) -> None:
        found = [each["id"] for each in await logins.tokens.documents() if name in (each["id"], each["name"])]
        if not found:
            raise NotFound(f"there is no token {name}", code="token_not_found")
        await logins.revoke_token(found[0])

    with_logins(database_url, find_and_delete)
