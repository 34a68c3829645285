"""Creates the tables, in one transaction and under a lock. The tables of another version are refused, never changed."""

import time

import sqlalchemy as sa

from dock_gateway.core.audit import GENESIS
from dock_gateway.core.event import time_id
from dock_gateway.storage.tables import BEGINNING, audit_chain, horizons, metadata, revisions

REVISION = "0022"  # Of `tables.py` and of the events in it; a change of these is a new one.

_LOCK = 0x646F636B67617465  # arbitrary; must be unique among the users of the database


def create_tables(connection: sa.Connection) -> None:
    """Create the tables if there are none; a second process waits for the first and has nothing to do.

    Raises:
        RuntimeError: The tables belong to another version of the gateway.
    """
    if connection.dialect.name == "postgresql":
        connection.execute(sa.select(sa.func.pg_advisory_xact_lock(_LOCK)))
    if not sa.inspect(connection).has_table(revisions.name):
        _create(connection)
    elif (revision := connection.scalar(sa.select(revisions))) != REVISION:
        raise RuntimeError(
            f"the history database has the tables of another version of the gateway (revision {revision}, not "
            f"{REVISION}), and nothing in it was changed: rename it to keep it, and create an empty one in its place, "
            "or set DOCK_GATEWAY_DATABASE_URL to another database"
        )


def _create(connection: sa.Connection) -> None:
    """Create all tables; fails if there is one of their names, which is another program's then."""
    metadata.create_all(connection, checkfirst=False)
    connection.execute(sa.insert(revisions).values(version_num=REVISION))
    # What happens later than now is complete, even while no event is stored.
    connection.execute(sa.insert(horizons).values(topic=BEGINNING, event_id=time_id(time.time_ns())))
    connection.execute(
        sa.insert(audit_chain).values(
            chain_id=1, anchor_sequence=0, anchor_digest=GENESIS, head_sequence=0, head_digest=GENESIS
        )
    )
