"""Creates or upgrades the tables, in one transaction and under a lock.

A new database gets the tables of `tables.py` as they are. An older one is upgraded with Alembic, from the baseline on:
a change of the tables is a change of `tables.py`, a file in `migrations/versions`, and `HEAD`.
"""

import logging
import time
from pathlib import Path

import sqlalchemy as sa

from dock_gateway.core.audit import GENESIS
from dock_gateway.core.event import time_id
from dock_gateway.storage.tables import BEGINNING, audit_chain, horizons, metadata

MIGRATIONS = Path(__file__).parent / "migrations"
HEAD = "0021"  # the newest revision
# The revisions before the baseline, 0018. No release has used them, and nothing upgrades them.
EARLY = frozenset(f"{number:04}" for number in range(1, 18))

_LOCK = 0x646F636B67617465  # arbitrary; must be unique among the users of the database


class EarlyTablesError(RuntimeError):
    """The tables are older than the first release.

    Args:
        revision: Their revision.
    """

    def __init__(self, revision: str) -> None:
        super().__init__(
            f"the history database has tables from before the first release (revision {revision}), which are not "
            "upgraded. Nothing in it was changed. Rename it to keep it, and create an empty one in its place, or set "
            "DOCK_GATEWAY_DATABASE_URL to another database"
        )
        self.revision = revision


def migrate(connection: sa.Connection) -> None:
    """Create or upgrade the tables to this version; a second process waits for the first and has nothing to do.

    Raises:
        EarlyTablesError: The tables are older than the first release.
        RuntimeError: The tables belong to another version of the gateway.
    """
    if connection.dialect.name == "postgresql":
        connection.execute(sa.select(sa.func.pg_advisory_xact_lock(_LOCK)))
    revision = _revision(connection)
    if revision in EARLY:
        raise EarlyTablesError(revision)
    if revision is None:
        _create(connection)
    if revision != HEAD:
        _upgrade(connection, new=revision is None)


def _revision(connection: sa.Connection) -> str | None:
    """Return the revision of the tables; None if there are none."""
    if not sa.inspect(connection).has_table("alembic_version"):
        return None
    return connection.scalar(sa.select(sa.column("version_num")).select_from(sa.table("alembic_version")))


def _create(connection: sa.Connection) -> None:
    """Create all tables; fails if there is one of their names, which is another program's then."""
    metadata.create_all(connection, checkfirst=False)
    # What happens later than now is complete, even while no event is stored.
    connection.execute(sa.insert(horizons).values(topic=BEGINNING, event_id=time_id(time.time_ns())))
    connection.execute(
        sa.insert(audit_chain).values(
            chain_id=1, anchor_sequence=0, anchor_digest=GENESIS, head_sequence=0, head_digest=GENESIS
        )
    )


def _upgrade(connection: sa.Connection, *, new: bool) -> None:
    """Upgrade the tables; if they are new, only note their revision.

    Raises:
        RuntimeError: The tables belong to another version of the gateway.
    """
    from alembic import command  # noqa: PLC0415 - takes longer to load than the tables to read
    from alembic.config import Config  # noqa: PLC0415
    from alembic.util import CommandError  # noqa: PLC0415

    logging.getLogger("alembic").setLevel(logging.WARNING)
    config = Config()
    config.set_main_option("script_location", str(MIGRATIONS).replace("%", "%%"))
    config.attributes["connection"] = connection
    try:
        command.stamp(config, HEAD) if new else command.upgrade(config, HEAD)
    except CommandError as error:
        raise RuntimeError(f"the history database belongs to another version of the gateway: {error}") from error
