"""Brings the tables up to date when the gateway starts, by Alembic, in one transaction and under a lock."""

import logging
from pathlib import Path

import sqlalchemy as sa

log = logging.getLogger(__name__)

# The newest revision, so that Alembic (a tenth of a second) is loaded only when there is something to do.
HEAD = "0004"
MIGRATIONS = Path(__file__).parent / "migrations"

_LOCK = 0x646F636B67617465  # any number that nobody else takes
_VERSION = sa.table("alembic_version", sa.column("version_num"))


def migrate(connection: sa.Connection) -> None:
    """Bring the tables up to date; a process that comes second waits for the first and finds the work done."""
    if connection.dialect.name == "postgresql":
        connection.execute(sa.select(sa.func.pg_advisory_xact_lock(_LOCK)))
    known = sa.inspect(connection).has_table("alembic_version")
    if known and connection.scalar(sa.select(_VERSION.c.version_num)) == HEAD:
        return
    from alembic import command  # noqa: PLC0415
    from alembic.config import Config  # noqa: PLC0415
    from alembic.util import CommandError  # noqa: PLC0415

    log.info("bringing the history's tables up to date")
    logging.getLogger("alembic").setLevel(logging.WARNING)
    config = Config()
    config.set_main_option("script_location", str(MIGRATIONS).replace("%", "%%"))
    config.attributes["connection"] = connection
    try:
        command.upgrade(config, "head")
    except CommandError as error:
        raise RuntimeError(f"the history database is of another version of the gateway: {error}") from error
