"""Feedback and battery events are kept for a while, and up to a size; goals, status and results always."""

import asyncio
import logging
import time
from datetime import UTC, datetime

import sqlalchemy as sa

from dock_gateway.events import time_id
from dock_gateway.history import store
from dock_gateway.history.database import Database
from dock_gateway.history.tables import events, idempotency_keys
from dock_gateway.history.writer import DATABASE_ERRORS

log = logging.getLogger(__name__)

INTERVAL = 60.0
TIMEOUT = 10.0
# Deleted in one transaction, so that nobody waits long for it.
CHUNK = 1000


class Retention:
    """Deletes what is too old, and the oldest of what is too much.

    Args:
        database: Where.
        max_age: In seconds.
        max_bytes: Of encoded feedback and battery events, without what the database needs besides.
    """

    def __init__(self, database: Database, max_age: float, max_bytes: int) -> None:
        self._database = database
        self._max_age = max_age
        self._max_bytes = max_bytes

    async def run(self) -> None:
        """Delete now and then, until canceled."""
        while True:
            await asyncio.sleep(INTERVAL)
            if self._database.prepared:
                try:
                    await self.enforce()
                except DATABASE_ERRORS as error:
                    log.warning("old events could not be deleted, and will be later: %s", error)

    async def enforce(self) -> int:
        """Delete all that has to go; returns how many events those were."""
        cutoff = time_id(time.time_ns() - int(self._max_age * 1e9))
        deleted = 0
        while count := (await self._delete(before=cutoff))[0]:
            deleted += count
        excess = await self._size() - self._max_bytes
        while excess > 0:
            count, size = await self._delete(excess=excess)
            if not count:
                break
            deleted += count
            excess -= size
        async with asyncio.timeout(TIMEOUT):
            await self._database.write(_delete_old_keys, durable=False)
        return deleted

    async def _size(self) -> int:
        async with asyncio.timeout(TIMEOUT):
            return await self._database.read(_size)

    async def _delete(self, *, before: str | None = None, excess: int | None = None) -> tuple[int, int]:
        async with asyncio.timeout(TIMEOUT):
            deleted = await self._database.write(_delete_oldest, before, excess, durable=False)
        if deleted[0]:
            await asyncio.sleep(0.01)  # for others who want to write
        return deleted


def _delete_old_keys(connection: sa.Connection) -> None:
    connection.execute(sa.delete(idempotency_keys).where(idempotency_keys.c.expires_at <= datetime.now(UTC)))


def _size(connection: sa.Connection) -> int:
    return connection.scalar(sa.select(sa.func.sum(events.c.size)).where(events.c.droppable)) or 0


def _delete_oldest(connection: sa.Connection, before: str | None, excess: int | None) -> tuple[int, int]:
    doomed = _oldest(connection, before, excess)
    if doomed:
        # First say that they are missing, then delete them: both or neither.
        gaps: dict[str, str] = {}
        for event_id, topic, _ in doomed:
            gaps[topic] = max(event_id, gaps.get(topic, ""))
        store.raise_horizons(connection, gaps)
        connection.execute(sa.delete(events).where(events.c.id.in_([event_id for event_id, *_ in doomed])))
    return len(doomed), sum(size for *_, size in doomed)


def _oldest(connection: sa.Connection, before: str | None, excess: int | None) -> list[tuple[str, str, int]]:
    query = sa.select(events.c.id, events.c.topic, events.c.size).where(events.c.droppable)
    if before is not None:
        query = query.where(events.c.id < before)
    query = query.order_by(events.c.id).limit(CHUNK).with_for_update(skip_locked=True)
    rows = [(row.id, row.topic, row.size) for row in connection.execute(query)]
    if excess is None:
        return rows
    taken: list[tuple[str, str, int]] = []
    for row in rows:
        if excess <= 0:
            break
        taken.append(row)
        excess -= row[2]
    return taken
