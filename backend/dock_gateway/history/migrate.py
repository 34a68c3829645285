"""Makes the tables, or brings them up to date: by Alembic, in one transaction and under a lock."""

import logging
from pathlib import Path

import sqlalchemy as sa

MIGRATIONS = Path(__file__).parent / "migrations"

_LOCK = 0x646F636B67617465  # any number that nobody else takes


def migrate(connection: sa.Connection) -> None:
    """See that the tables are of this version; a process that comes second waits for the first and finds the work done.

    Raises:
        RuntimeError: The tables are those of another version of the gateway.
    """
    from alembic import command  # noqa: PLC0415 - a quarter of a second, on the thread that opens the database
    from alembic.config import Config  # noqa: PLC0415
    from alembic.util import CommandError  # noqa: PLC0415

    if connection.dialect.name == "postgresql":
        connection.execute(sa.select(sa.func.pg_advisory_xact_lock(_LOCK)))
    logging.getLogger("alembic").setLevel(logging.WARNING)
    config = Config()
    config.set_main_option("script_location", str(MIGRATIONS).replace("%", "%%"))
    config.attributes["connection"] = connection
    try:
        command.upgrade(config, "head")
    except CommandError as error:
        raise RuntimeError(f"the history database is of another version of the gateway: {error}") from error
