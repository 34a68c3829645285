"""Deletes old feedback and battery events, and later old ended goals, by age and by size."""

import asyncio
import logging
import time
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from functools import partial

import sqlalchemy as sa

from dock_gateway.core.event import time_id
from dock_gateway.core.goal import GoalStatus
from dock_gateway.history import audit, notes, queries
from dock_gateway.history.database import DATABASE_ERRORS, Database
from dock_gateway.history.tables import IS_KEPT, events, goals, idempotency_keys

log = logging.getLogger(__name__)

INTERVAL = 60.0  # seconds between two runs
TIMEOUT = 10.0  # seconds per transaction
# The maximum number of events, and of goals (with their events), deleted per transaction, to keep it short.
CHUNK, GOAL_CHUNK = 1000, 20
# Bytes of a status or result event in the file besides its text: ids, indexes and its share of the goal's row.
OVERHEAD = 1000
# The pause after each transaction, so that other writers get the lock and the disk: in seconds, or as a multiple of
# the time that the transaction took, whichever is longer.
PAUSE, REST = 0.05, 4

_UNFINISHED = [status.value for status in GoalStatus if not status.final]


@dataclass(frozen=True)
class Deleted:
    """What a transaction has deleted: number of events and goals, and bytes."""

    events: int = 0
    goals: int = 0
    size: int = 0


@dataclass(frozen=True)
class Limits:
    """How much is kept.

    Attributes:
        event_age: Maximum age of feedback and battery events, in seconds.
        event_bytes: Maximum size of encoded feedback and battery events, without the database's overhead.
        goal_age: Maximum age of goals with their events, in seconds.
        goal_bytes: Maximum size of goals with their status and result events; about their size in the file.
        audit_age: Maximum age of the entries of the audit log, in seconds.
        audit_entries: Maximum number of them.
    """

    event_age: float
    event_bytes: int
    goal_age: float
    goal_bytes: int
    audit_age: float
    audit_entries: int


class Retention:
    """Deletes what exceeds the maximum age, and the oldest entries beyond the maximum size.

    Args:
        database: The database to delete from.
        limits: How much is kept.
    """

    def __init__(self, database: Database, limits: Limits) -> None:
        self._database = database
        self._limits = limits

    async def run(self) -> None:
        """Enforce the limits every minute, until canceled."""
        while True:
            await asyncio.sleep(INTERVAL)
            if self._database.prepared:
                try:
                    await self.enforce()
                except DATABASE_ERRORS as error:
                    log.warning("old entries could not be deleted; retrying later: %s", error)

    async def enforce(self) -> int:
        """Delete everything beyond the limits; return the number of deleted events."""
        limits = self._limits
        event_id = time_id(time.time_ns() - int(limits.event_age * 1e9))
        created = datetime.now(UTC) - timedelta(seconds=limits.goal_age)
        deleted = await self._delete(partial(_delete_events, before=event_id))
        deleted += await self._delete(_delete_events, await self._read(_event_bytes) - limits.event_bytes)
        deleted += await self._delete(partial(_delete_goals, before=created))
        deleted += await self._delete(_delete_goals, await self._read(_goal_bytes) - limits.goal_bytes)
        async with asyncio.timeout(TIMEOUT):
            await self._database.write(_delete_old_keys, durable=False)
        await self._delete_audit()
        return deleted

    async def _delete_audit(self) -> None:
        before = datetime.now(UTC) - timedelta(seconds=self._limits.audit_age)
        deleted = audit.CHUNK
        while deleted == audit.CHUNK:
            async with asyncio.timeout(TIMEOUT):
                deleted = await self._database.write(audit.delete_old, before, self._limits.audit_entries)
            await asyncio.sleep(PAUSE)

    async def _read(self, size: Callable[[sa.Connection], int]) -> int:
        async with asyncio.timeout(TIMEOUT):
            return await self._database.read(size)

    async def _delete(self, delete: Callable[[sa.Connection, int | None], Deleted], excess: int | None = None) -> int:
        """Delete in small transactions until nothing is left to delete, or `excess` bytes are gone."""
        events = 0
        while excess is None or excess > 0:
            start = time.monotonic()
            async with asyncio.timeout(TIMEOUT):
                deleted = await self._database.write(delete, excess, durable=False)
            if not (deleted.events or deleted.goals):
                break
            events += deleted.events
            excess = None if excess is None else excess - deleted.size
            await asyncio.sleep(max(PAUSE, REST * (time.monotonic() - start)))
        return events


def _delete_old_keys(connection: sa.Connection) -> None:
    connection.execute(sa.delete(idempotency_keys).where(idempotency_keys.c.expires_at <= datetime.now(UTC)))


def _event_bytes(connection: sa.Connection) -> int:
    return connection.scalar(sa.select(sa.func.sum(events.c.size)).where(events.c.droppable)) or 0


def _goal_bytes(connection: sa.Connection) -> int:
    size = sa.func.sum(events.c.size) + OVERHEAD * sa.func.count()
    return connection.scalar(sa.select(size).where(IS_KEPT)) or 0


# ---------------------------------------------------------------------- feedback and battery events


def _delete_events(connection: sa.Connection, excess: int | None, before: str | None = None) -> Deleted:
    """Delete the oldest events: as many as the excess requires, or those before an id."""
    query = sa.select(events.c.id, events.c.topic, events.c.size).where(events.c.droppable)
    if before is not None:
        query = query.where(events.c.id < before)
    query = query.order_by(events.c.id).limit(CHUNK).with_for_update(skip_locked=True)
    doomed: dict[str, str] = {}
    size = 0
    for row in connection.execute(query):
        if excess is not None and size >= excess:
            break
        doomed[row.id] = row.topic
        size += row.size
    _delete_by_id(connection, doomed)
    return Deleted(events=len(doomed), size=size)


def _delete_by_id(connection: sa.Connection, doomed: dict[str, str]) -> None:
    """Delete events and record them as missing, in one transaction; `doomed` maps ids to topics."""
    gaps: dict[str, str] = {}
    for event_id, topic in doomed.items():
        gaps[topic] = max(event_id, gaps.get(topic, ""))
    queries.raise_horizons(connection, gaps)
    connection.execute(sa.delete(events).where(events.c.id.in_(list(doomed))))


# ---------------------------------------------------------------------- goals


def _delete_goals(connection: sa.Connection, excess: int | None, before: datetime | None = None) -> Deleted:
    """Delete the oldest ended goals with their events; or those created, or created and lost, before a time.

    A goal whose idempotency key is still valid stays: a retry would send it again. If the goals have more events than
    fit in a transaction, only events are deleted first.
    """
    # `not in`, because with `in` SQLite would scan all ended goals by the index on the status, and sort them.
    gone: sa.ColumnElement[bool] = goals.c.status.not_in(_UNFINISHED)
    if before is not None:
        lost = sa.and_(goals.c.status == GoalStatus.LOST.value, goals.c.updated_at < before)
        gone = sa.and_(goals.c.created_at < before, sa.or_(gone, lost))
    key = sa.exists().where(
        idempotency_keys.c.goal_id == goals.c.goal_id, idempotency_keys.c.expires_at > datetime.now(UTC)
    )
    query = sa.select(goals.c.goal_id).where(gone, ~key).order_by(goals.c.created_at, goals.c.goal_id)
    doomed = list(connection.scalars(query.limit(GOAL_CHUNK).with_for_update(skip_locked=True)))
    of_doomed = sa.select(events.c.id, events.c.topic, events.c.size, events.c.droppable)
    rows = connection.execute(of_doomed.where(events.c.goal_id.in_(doomed)).limit(CHUNK)).all()
    _delete_by_id(connection, {row.id: row.topic for row in rows})
    size = sum(row.size + OVERHEAD for row in rows if not row.droppable)
    if len(rows) == CHUNK:
        return Deleted(events=len(rows), size=size)
    notes.delete_of(connection, doomed)
    connection.execute(sa.delete(goals).where(goals.c.goal_id.in_(doomed)))
    return Deleted(len(rows), len(doomed), size)
