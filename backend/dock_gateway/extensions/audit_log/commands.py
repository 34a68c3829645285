"""`dock-gateway audit verify`: checks in the history's database that no entry of the audit log was changed."""

import asyncio
import sys

import click

from dock_gateway.cli.accounts import database_option
from dock_gateway.cli.databases import Choice
from dock_gateway.cli.groups import CommandGroup
from dock_gateway.cli.options import read_settings
from dock_gateway.core.audit import START, Verdict


@click.group(cls=CommandGroup)
def audit() -> None:
    """Check the audit log."""


@audit.command(name="verify")
@click.option("--expect", metavar="DIGEST", help="A digest from the gateway's log, which a row must have.")
@database_option
def verify_audit(expect: str | None, database_url: str | None) -> None:
    """Check that no row of the audit log was changed, removed or inserted. The gateway may run.

    The exit code is 1 if there is such a row. The first one is printed.
    """
    settings = read_settings({"database_url": database_url})
    if settings.database_url == "memory:":
        raise click.UsageError("the history `memory:` keeps no audit log: name a database with --database-url")
    choice = Choice(settings)
    verdict = asyncio.run(_check(settings.database, expect and expect.strip().lower()))
    choice.report("read")
    if verdict.intact:
        first = verdict.last.sequence - verdict.intact + 1
        click.echo(f"{verdict.intact} rows are intact: {first} to {verdict.last.sequence}")
    else:
        click.echo("no row is intact" if verdict.fault else "there are no rows")
    if verdict.last != START:
        click.echo(f"digest of row {verdict.last.sequence}: {verdict.last.digest}")
    if verdict.fault is not None:
        click.echo(verdict.fault, err=True)
        sys.exit(1)


COMMANDS = (audit,)


async def _check(url: str, expected: str | None) -> Verdict:
    from dock_gateway.storage.audit import check  # noqa: PLC0415 - takes a second
    from dock_gateway.storage.database import DATABASE_ERRORS, brief  # noqa: PLC0415
    from dock_gateway.storage.history import open_database  # noqa: PLC0415

    database = open_database(url)
    try:
        await database.prepare()
        return await database.read(check, expected)
    except DATABASE_ERRORS as error:
        raise click.ClickException(f"the database does not answer: {brief(error)}") from None
    finally:
        await database.close()
