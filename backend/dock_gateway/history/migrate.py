"""Makes the tables, or brings them up to date by Alembic, in one transaction and under a lock."""

import logging
from pathlib import Path

import sqlalchemy as sa

from dock_gateway.history.tables import metadata

log = logging.getLogger(__name__)

# The newest revision, so that Alembic (a quarter of a second, 8 MB) is loaded only where there are older tables.
HEAD = "0006"
MIGRATIONS = Path(__file__).parent / "migrations"

_LOCK = 0x646F636B67617465  # any number that nobody else takes
_VERSION = sa.Table(  # as Alembic makes it
    "alembic_version",
    sa.MetaData(),
    sa.Column("version_num", sa.String(32), nullable=False),
    sa.PrimaryKeyConstraint("version_num", name="alembic_version_pkc"),
)


def migrate(connection: sa.Connection) -> None:
    """See that the tables are of this version; a process that comes second waits for the first and finds the work done.

    Raises:
        RuntimeError: The tables are those of another version of the gateway.
    """
    if connection.dialect.name == "postgresql":
        connection.execute(sa.select(sa.func.pg_advisory_xact_lock(_LOCK)))
    tables = set(sa.inspect(connection).get_table_names())
    if tables.isdisjoint({_VERSION.name, *metadata.tables}):
        make(connection)
    elif _VERSION.name not in tables or connection.scalar(sa.select(_VERSION.c.version_num)) != HEAD:
        upgrade(connection)


def make(connection: sa.Connection) -> None:
    """Make the tables of this version where there are none."""
    log.info("making the history's tables")
    metadata.create_all(connection, checkfirst=False)
    _VERSION.create(connection)
    connection.execute(sa.insert(_VERSION).values(version_num=HEAD))


def upgrade(connection: sa.Connection) -> None:
    """Bring the tables of an earlier version, or none, up to date.

    Raises:
        RuntimeError: They are those of another version of the gateway.
    """
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
