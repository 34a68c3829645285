"""Creates or upgrades the tables with Alembic, in one transaction and under a lock."""

import logging
from pathlib import Path

import sqlalchemy as sa
from alembic import command
from alembic.config import Config
from alembic.util import CommandError

MIGRATIONS = Path(__file__).parent / "migrations"

_LOCK = 0x646F636B67617465  # arbitrary; must be unique among the users of the database


def migrate(connection: sa.Connection) -> None:
    """Create or upgrade the tables to this version; a second process waits for the first and has nothing to do.

    Raises:
        RuntimeError: The tables belong to another version of the gateway.
    """
    if connection.dialect.name == "postgresql":
        connection.execute(sa.select(sa.func.pg_advisory_xact_lock(_LOCK)))
    logging.getLogger("alembic").setLevel(logging.WARNING)
    config = Config()
    config.set_main_option("script_location", str(MIGRATIONS).replace("%", "%%"))
    config.attributes["connection"] = connection
    try:
        command.upgrade(config, "head")
    except CommandError as error:
        raise RuntimeError(f"the history database belongs to another version of the gateway: {error}") from error
