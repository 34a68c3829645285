"""The audit log in a database that several gateways may share. Rows are only added, never changed."""

from collections.abc import Iterator, Sequence
from datetime import datetime
from typing import Any

import sqlalchemy as sa

from dock_gateway.core.audit import (
    START,
    AuditEntry,
    AuditFilter,
    AuditRow,
    Link,
    RequestOutcome,
    Verdict,
    extend,
    verify,
)
from dock_gateway.storage.immediate import ImmediateWriter
from dock_gateway.storage.queries import insert_into
from dock_gateway.storage.reader import Reader
from dock_gateway.storage.tables import audit, audit_chain

CHUNK = 1000  # rows deleted in a transaction, and read at a time

_FAILED = 500
_STATUSES = {
    RequestOutcome.DONE: audit.c.status < 400,
    RequestOutcome.REFUSED: audit.c.status.between(400, _FAILED - 1),
    RequestOutcome.FAILED: audit.c.status >= _FAILED,
}

# Built once: that takes longer than SQLite takes to run them.
_CHAIN = sa.select(audit_chain.c.head_sequence, audit_chain.c.head_digest).with_for_update()
_STORED = sa.select(audit.c.id).where(audit.c.id.in_(sa.bindparam("names", expanding=True)))
_HIGHEST = sa.select(sa.func.max(audit.c.sequence))
_ADD = sa.insert(audit)
_ADVANCE = sa.update(audit_chain).values(head_sequence=sa.bindparam("sequence"), head_digest=sa.bindparam("digest"))


class AuditStore:
    """Stores the entries of the audit log.

    Both methods raise `Unavailable` (`history_unavailable`) if the database does not answer in time.

    Args:
        reader: Reads from the database.
        writer: Writes to it.
    """

    def __init__(self, reader: Reader, writer: ImmediateWriter) -> None:
        self._reader = reader
        self._writer = writer

    async def append(self, entries: Sequence[AuditEntry], *, durable: bool = True) -> list[AuditRow]:
        """Store entries in their order; return the new rows. Entries that are stored already are left out.

        Entries that are not `durable` may be lost in a power cut. That costs less, and new goals wait less for it.
        """
        return await self._writer.write(append, entries, durable=durable)

    async def page(self, wanted: AuditFilter, *, limit: int, before: int | None = None) -> list[AuditRow]:
        """Return rows, newest first; with `before`, only rows before that number.

        A filter that few of many rows pass takes its time.
        """
        return await self._reader.read_much(_page, wanted, limit, before)


def append(connection: sa.Connection, entries: Sequence[AuditEntry]) -> list[AuditRow]:
    """Add rows to the chain, one gateway at a time: the others wait for the lock on the row of the chain."""
    head = _lock_chain(connection)
    stored = set(connection.scalars(_STORED, {"names": [entry.id for entry in entries]}))
    # A row that somebody else has added must not keep the gateway from adding its own.
    highest = connection.scalar(_HIGHEST) or 0
    start = Link(max(head.sequence, highest), head.digest)
    rows = list(extend(start, (entry for entry in entries if entry.id not in stored)))
    if rows:
        values = [{"sequence": row.sequence, **vars(row.entry), "digest": row.digest} for row in rows]
        connection.execute(_ADD, values)
        connection.execute(_ADVANCE, {"sequence": rows[-1].sequence, "digest": rows[-1].digest})
    return rows


def _lock_chain(connection: sa.Connection) -> Link:
    """Return the last row that was written, and keep other gateways from writing until the transaction ends."""
    first = {
        "chain_id": 1,
        "anchor_sequence": START.sequence,
        "anchor_digest": START.digest,
        "head_sequence": START.sequence,
        "head_digest": START.digest,
    }
    row = connection.execute(_CHAIN).first()
    if row is None:  # somebody has deleted it; `verify` finds that rows are missing or too many
        connection.execute(insert_into(connection.dialect.name, audit_chain).on_conflict_do_nothing(), first)
        row = connection.execute(_CHAIN).one()
    return Link(*row)


def delete_old(connection: sa.Connection, before: datetime, most: int) -> int:
    """Delete the oldest rows, up to the first that is to be kept; keep the digest of the last one deleted.

    Args:
        connection: The database.
        before: Rows from before this time are deleted.
        most: The maximum number of rows that are kept.
    """
    head = _lock_chain(connection)
    oldest = sa.select(audit.c.sequence, audit.c.digest, audit.c.acted_at).order_by(audit.c.sequence).limit(CHUNK)
    doomed: list[Link] = []
    for row in connection.execute(oldest):
        if row.acted_at >= before and row.sequence > head.sequence - most:
            break
        doomed.append(Link(row.sequence, row.digest))
    if doomed:
        sequence, digest = doomed[-1]
        connection.execute(sa.delete(audit).where(audit.c.sequence <= sequence))
        connection.execute(sa.update(audit_chain).values(anchor_sequence=sequence, anchor_digest=digest))
    return len(doomed)


def check(connection: sa.Connection, expected: str | None = None) -> Verdict:
    """Check the whole chain as it was at one moment, while gateways go on writing."""
    if connection.dialect.name == "postgresql":  # a transaction of SQLite sees one moment anyway
        connection.execute(sa.text("SET TRANSACTION ISOLATION LEVEL REPEATABLE READ"))
    chain = connection.execute(sa.select(audit_chain)).first()
    if chain is None:
        return Verdict(0, START, "the table audit_chain is empty: the ends of the chain were deleted")
    anchor, head = Link(chain.anchor_sequence, chain.anchor_digest), Link(chain.head_sequence, chain.head_digest)
    try:
        return verify(_all(connection), anchor, head, expected)
    except (ValueError, TypeError) as error:
        return Verdict(0, START, f"a row cannot be read: {error}")


def _all(connection: sa.Connection) -> Iterator[AuditRow]:
    last: int | None = None
    while True:
        query = sa.select(audit).order_by(audit.c.sequence).limit(CHUNK)
        rows = connection.execute(query if last is None else query.where(audit.c.sequence > last)).all()
        yield from map(_row, rows)
        if len(rows) < CHUNK:
            return
        last = rows[-1].sequence


def _page(connection: sa.Connection, wanted: AuditFilter, limit: int, before: int | None) -> list[AuditRow]:
    query = sa.select(audit).where(*_conditions(wanted))
    if before is not None:
        query = query.where(audit.c.sequence < before)
    return [_row(row) for row in connection.execute(query.order_by(audit.c.sequence.desc()).limit(limit))]


def _conditions(wanted: AuditFilter) -> Iterator[sa.ColumnElement[bool]]:
    equal = {audit.c.principal: wanted.principal, audit.c.what: wanted.what, audit.c.goal_id: wanted.goal_id}
    yield from (column == value for column, value in equal.items() if value is not None)
    if wanted.robot is not None:
        listed = sa.literal(",").concat(audit.c.robot).concat(",")
        yield listed.contains(f",{wanted.robot},", autoescape=True)
    if wanted.outcome is not None:
        yield _STATUSES[wanted.outcome]
    if wanted.since is not None:
        yield audit.c.acted_at >= wanted.since
    if wanted.until is not None:
        yield audit.c.acted_at < wanted.until


def _row(row: Any) -> AuditRow:
    sequence, *fields, digest = row
    return AuditRow(sequence, AuditEntry(*fields), digest)
