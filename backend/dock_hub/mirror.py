"""Stores goals and events of sites, with the position of each stream, in one transaction."""

from dataclasses import dataclass, field
from typing import Any

import orjson
import sqlalchemy as sa

from dock_gateway.core.errors import Unavailable
from dock_gateway.core.event import Event
from dock_gateway.core.goal import Goal
from dock_gateway.storage import History, queries
from dock_gateway.storage.database import brief, is_about_data
from dock_gateway.storage.rows import Batch
from dock_gateway.storage.tables import documents, events

CURSOR = "site_cursor"


class RefusedError(ValueError):
    """The database cannot take it: a value is refused, or a goal has the id of one on another action."""


@dataclass
class MirrorBatch:
    """The contents of one transaction.

    Attributes:
        goals: New or changed goals. An older state never replaces a newer one.
        events: Their events. One whose key is stored already is left out.
        cursors: Of each site, the id of its last event that is in here or was stored before.
    """

    goals: list[Goal] = field(default_factory=list)
    events: list[Event] = field(default_factory=list)
    cursors: dict[str, str] = field(default_factory=dict)


class Mirror:
    """The mirror of the sites in a database, written by one hub.

    Args:
        history: The database that they are in.
    """

    def __init__(self, history: History) -> None:
        self._reader = history.reader
        self._writer = history.immediate

    async def cursor(self, site: str) -> str | None:
        """Return the id of the last event of a site that is stored; None if it was never read.

        Raises:
            Unavailable: The database does not answer (`history_unavailable`).
        """
        return await self._reader.read(_cursor, site)

    async def forget(self, site: str) -> None:
        """Forget how far a site was read: it is read again from the beginning. Nothing is stored twice.

        Raises:
            Unavailable: The database does not answer (`history_unavailable`).
        """
        await self._writer.write(_forget, site)

    async def known_keys(self, keys: list[str]) -> set[str]:
        """Return those of the keys of events that are stored.

        Raises:
            Unavailable: The database does not answer (`history_unavailable`).
        """
        return await self._reader.read(_known_keys, keys) if keys else set()

    async def take(self, batch: MirrorBatch) -> set[str]:
        """Store goals, events and cursors, all or nothing. It can be repeated after an error.

        Returns:
            The ids of the events that are stored as given. The others are stored under the same keys already.

        Raises:
            RefusedError: A goal is known on another action, as one of another site; or a value is refused.
            Unavailable: The database does not answer (`history_unavailable`).
        """
        try:
            return await self._writer.write(_take, batch)
        except Unavailable as error:
            if isinstance(error.__cause__, Exception) and is_about_data(error.__cause__):
                raise RefusedError(brief(error.__cause__)) from None
            raise


def _cursor(connection: sa.Connection, site: str) -> str | None:
    query = sa.select(documents.c.document).where(documents.c.kind == CURSOR, documents.c.key == site)
    document = connection.scalar(query)
    return None if document is None else orjson.loads(document)["event_id"]


def _forget(connection: sa.Connection, site: str) -> None:
    connection.execute(sa.delete(documents).where(documents.c.kind == CURSOR, documents.c.key == site))


def _known_keys(connection: sa.Connection, keys: list[str]) -> set[str]:
    return {key for key in connection.scalars(sa.select(events.c.key).where(events.c.key.in_(keys))) if key is not None}


def _take(connection: sa.Connection, batch: MirrorBatch) -> set[str]:
    known = queries.goals_by_id(connection, [goal.goal_id for goal in batch.goals])
    for goal in batch.goals:
        if goal.goal_id in known and known[goal.goal_id].action_name != goal.action_name:
            raise RefusedError(f"{goal.action_name} has a goal with the id of one on another action")
    queries.write(connection, Batch(goals=batch.goals, events=batch.events))
    insert = queries.insert_into(connection.dialect.name, documents)
    for site, event_id in sorted(batch.cursors.items()):
        row: dict[str, Any] = {"kind": CURSOR, "key": site, "document": orjson.dumps({"event_id": event_id})}
        connection.execute(insert.on_conflict_do_update(index_elements=["kind", "key"], set_=row), row)
    ids = [event.id for event in batch.events]
    return set(connection.scalars(sa.select(events.c.id).where(events.c.id.in_(ids)))) if ids else set()
