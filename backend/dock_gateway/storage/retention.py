"""Deletes old feedback and battery events, and later old ended goals, by age and by size."""

import asyncio
import logging
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta
from functools import partial
from typing import Any, Generic, TypeVar

import sqlalchemy as sa

from dock_gateway.core.event import time_id
from dock_gateway.core.goal import GoalStatus
from dock_gateway.storage import audit, notes, queries
from dock_gateway.storage.database import DATABASE_ERRORS, Database
from dock_gateway.storage.tables import IS_DROPPABLE, IS_KEPT, events, goals, idempotency_keys

log = logging.getLogger(__name__)

INTERVAL = 60.0  # seconds between two runs
TIMEOUT = 10.0  # seconds per transaction
# Seconds between two runs for a history in memory.
MEMORY_INTERVAL = 15.0
# Bytes of events that a history in memory keeps.
MEMORY_EVENT_BYTES = 5_000_000
# Rows of the audit log, and of idempotency keys, that a history in memory keeps.
MEMORY_ROWS = 10_000
# The maximum number of events deleted per transaction, to keep it short.
CHUNK = 1000
# The maximum number of goals, with their events, deleted per transaction.
GOAL_CHUNK = 20
# The maximum number of transactions of one kind in a run: what is added during a run is for the next one.
MAX_CHUNKS = 10_000
# The maximum number of events that are added up to find the last one that is too much.
MOST_EVENTS = 20_000
# The same for goals.
MOST_GOALS = 2000
# Bytes of a status or result event in the file besides its text: ids, indexes and its share of the goal's row.
OVERHEAD = 1000
# Seconds of the pause after each transaction, so that other writers get the lock and the disk.
PAUSE = 0.05
# The same as a multiple of the time that the transaction took. The longer pause counts.
REST = 4

# `not in`, because with `in` SQLite would scan all ended goals by the index on the status, and sort them.
HAS_ENDED = goals.c.status.not_in([status.value for status in GoalStatus if not status.final])

T = TypeVar("T")
Excess = TypeVar("Excess")


@dataclass(frozen=True)
class Deleted:
    """The numbers of events and goals that a transaction has deleted."""

    events: int = 0
    goals: int = 0


@dataclass(frozen=True)
class ExcessRule(Generic[Excess]):
    """A rule that chooses what is deleted when there is too much.

    Attributes:
        find: Returns what must go so that some bytes are left; None if nothing must go.
        delete: Deletes a part of that, in a short transaction.
    """

    find: Callable[[int, sa.Connection], Excess | None]
    delete: Callable[[sa.Connection, Excess], Deleted]


@dataclass(frozen=True)
class Limits:
    """The maximum size and age of what is kept.

    Attributes:
        event_age: Maximum age of feedback and battery events, in seconds.
        event_bytes: Maximum size of encoded feedback and battery events, without the database's overhead.
        goal_age: Maximum age of goals with their events, in seconds.
        goal_bytes: Maximum size of goals with their status and result events; about their size in the file.
        audit_age: Maximum age of the entries of the audit log, in seconds.
        audit_entries: Maximum number of them.
        goals: Maximum number of ended goals whose idempotency key is not valid; None: there is none.
        keys: Maximum number of idempotency keys; None: there is none.
        interval: Seconds between two runs.
    """

    event_age: float
    event_bytes: int
    goal_age: float
    goal_bytes: int
    audit_age: float
    audit_entries: int
    goals: int | None = None
    keys: int | None = None
    interval: float = INTERVAL


def in_memory(limits: Limits, most_goals: int) -> Limits:
    """Return the limits of a history in memory: smaller ones, enforced more often."""
    return replace(
        limits,
        event_bytes=min(limits.event_bytes, MEMORY_EVENT_BYTES),
        audit_entries=min(limits.audit_entries, MEMORY_ROWS),
        goals=most_goals,
        keys=MEMORY_ROWS,
        interval=MEMORY_INTERVAL,
    )


class Retention:
    """Deletes what exceeds the maximum age, and the oldest entries beyond the maximum size.

    Args:
        database: The database to delete from.
        limits: How much is kept.

    Attributes:
        goals_by_size: Enforces the maximum size of goals; by default, the oldest ones go.
    """

    def __init__(self, database: Database, limits: Limits) -> None:
        self.goals_by_size: ExcessRule[Any] = OLDEST_GOALS
        self._database = database
        self._limits = limits

    async def run(self) -> None:
        """Enforce the limits again and again, until canceled."""
        while True:
            await asyncio.sleep(self._limits.interval)
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
        deleted = await self._delete(_delete_events, event_id)
        deleted += await self._delete_excess(_delete_events, partial(_last_event_beyond, limits.event_bytes))
        deleted += await self._delete(partial(delete_goals, lost=True), created)
        rule = self.goals_by_size
        deleted += await self._delete_excess(rule.delete, partial(rule.find, limits.goal_bytes))
        if limits.goals is not None:
            deleted += await self._delete_excess(delete_goals, partial(_last_goal_but, limits.goals))
        async with asyncio.timeout(TIMEOUT):
            await self._database.write(delete_old_keys, limits.keys, durable=False)
        await self._delete_audit()
        return deleted

    async def _delete_audit(self) -> None:
        before = datetime.now(UTC) - timedelta(seconds=self._limits.audit_age)
        deleted = audit.CHUNK
        while deleted == audit.CHUNK:
            async with asyncio.timeout(TIMEOUT):
                deleted = await self._database.write(audit.delete_old, before, self._limits.audit_entries)
            await asyncio.sleep(PAUSE)

    async def _delete(self, delete: Callable[[sa.Connection, T], Deleted], last: T) -> int:
        """Delete what is not later than `last`, in small transactions; return the number of deleted events."""
        events = 0
        for _ in range(MAX_CHUNKS):
            start = time.monotonic()
            async with asyncio.timeout(TIMEOUT):
                deleted = await self._database.write(delete, last, durable=False)
            if not (deleted.events or deleted.goals):
                return events
            events += deleted.events
            await asyncio.sleep(max(PAUSE, REST * (time.monotonic() - start)))
        return events

    async def _delete_excess(
        self, delete: Callable[[sa.Connection, T], Deleted], find_last: Callable[[sa.Connection], T | None]
    ) -> int:
        """Delete until nothing is too much; return the number of deleted events.

        Gateways that share the database find the same last one, so together they delete no more than one alone.
        """
        events = 0
        while (last := await self._read(find_last)) is not None and (deleted := await self._delete(delete, last)):
            events += deleted
        return events

    async def _read(self, find: Callable[[sa.Connection], T]) -> T:
        async with asyncio.timeout(TIMEOUT):
            return await self._database.read(find)


def delete_old_keys(connection: sa.Connection, most: int | None) -> None:
    """Delete the keys that have expired, and the oldest of those beyond a number."""
    last = datetime.now(UTC)
    if most is not None:
        expiry = idempotency_keys.c.expires_at
        last = connection.scalar(sa.select(expiry).order_by(expiry.desc()).offset(most).limit(1)) or last
    connection.execute(sa.delete(idempotency_keys).where(idempotency_keys.c.expires_at <= last))


def last_beyond(connection: sa.Connection, most: int, total: sa.Select[Any], oldest: sa.Select[Any]) -> Any:
    """Return the last entry that must go so that `most` bytes are left, in one statement; None if nothing must go.

    Args:
        connection: The database.
        most: How much is kept.
        total: Selects how much there is.
        oldest: Selects the oldest entries that may go, in order: their place in it, and their size.
    """
    place, size = oldest.subquery().c
    before = sa.func.coalesce(sa.func.sum(size).over(order_by=place, rows=(None, -1)), 0)
    entries = sa.select(place, before.label("before")).subquery()
    excess = total.scalar_subquery() - sa.literal(most, sa.BigInteger)
    return connection.scalar(sa.select(sa.func.max(entries.c[0])).where(entries.c.before < excess))


# ---------------------------------------------------------------------- feedback and battery events


def _last_event_beyond(most: int, connection: sa.Connection) -> str | None:
    total = sa.select(sa.func.sum(events.c.size)).where(IS_DROPPABLE)
    oldest = sa.select(events.c.id, events.c.size).where(IS_DROPPABLE).order_by(events.c.id).limit(MOST_EVENTS)
    last: str | None = last_beyond(connection, most, total, oldest)
    return last


def _delete_events(connection: sa.Connection, last: str) -> Deleted:
    """Delete the oldest events up to an id."""
    query = sa.select(events.c.id, events.c.topic).where(IS_DROPPABLE, events.c.id <= last)
    query = query.order_by(events.c.id).limit(CHUNK).with_for_update(skip_locked=True)
    doomed = {row.id: row.topic for row in connection.execute(query)}
    _delete_by_id(connection, doomed)
    return Deleted(events=len(doomed))


def _delete_by_id(connection: sa.Connection, doomed: dict[str, str]) -> None:
    """Delete events and record them as missing, in one transaction; `doomed` maps ids to topics."""
    gaps: dict[str, str] = {}
    for event_id, topic in doomed.items():
        gaps[topic] = max(event_id, gaps.get(topic, ""))
    queries.raise_horizons(connection, gaps)
    connection.execute(sa.delete(events).where(events.c.id.in_(list(doomed))))


# ---------------------------------------------------------------------- goals


def _last_goal_beyond(most: int, connection: sa.Connection) -> datetime | None:
    size = sa.func.sum(events.c.size) + OVERHEAD * sa.func.count()
    total = sa.select(size).where(IS_KEPT)
    of_goal = total.where(events.c.goal_id == goals.c.goal_id).scalar_subquery()
    oldest = sa.select(goals.c.created_at, sa.func.coalesce(of_goal, 0)).where(HAS_ENDED, _has_no_key())
    last: datetime | None = last_beyond(connection, most, total, oldest.order_by(goals.c.created_at).limit(MOST_GOALS))
    return last


def _last_goal_but(most: int, connection: sa.Connection) -> datetime | None:
    """Return the time of the newest goal that must go so that `most` are left; None if none must go."""
    query = sa.select(goals.c.created_at).where(HAS_ENDED, _has_no_key())
    last: datetime | None = connection.scalar(query.order_by(goals.c.created_at.desc()).offset(most).limit(1))
    return last


def delete_goals(
    connection: sa.Connection,
    last: datetime,
    *,
    lost: bool = False,
    among: Sequence[sa.ColumnElement[bool]] = (HAS_ENDED,),
) -> Deleted:
    """Delete the oldest ended goals with their events, up to a time of creation; also those `lost` up to then.

    With `among`, those that it selects. If the goals have more events than fit in a transaction, only events are
    deleted first.
    """
    gone: sa.ColumnElement[bool] = sa.and_(*among)
    if lost:
        gone = sa.or_(gone, sa.and_(goals.c.status == GoalStatus.LOST.value, goals.c.updated_at <= last))
    query = sa.select(goals.c.goal_id).where(goals.c.created_at <= last, gone, _has_no_key())
    query = query.order_by(goals.c.created_at, goals.c.goal_id).limit(GOAL_CHUNK).with_for_update(skip_locked=True)
    doomed = list(connection.scalars(query))
    of_doomed = sa.select(events.c.id, events.c.topic).where(events.c.goal_id.in_(doomed))
    rows = connection.execute(of_doomed.limit(CHUNK)).all()
    _delete_by_id(connection, {row.id: row.topic for row in rows})
    if len(rows) == CHUNK:
        return Deleted(events=len(rows))
    notes.delete_of(connection, doomed)
    connection.execute(sa.delete(goals).where(goals.c.goal_id.in_(doomed)))
    return Deleted(len(rows), len(doomed))


OLDEST_GOALS = ExcessRule(_last_goal_beyond, delete_goals)


def _has_no_key() -> sa.ColumnElement[bool]:
    """A goal whose idempotency key is still valid stays: a retry would send it again."""
    is_valid = idempotency_keys.c.expires_at > datetime.now(UTC)
    return ~sa.exists().where(idempotency_keys.c.goal_id == goals.c.goal_id, is_valid)
