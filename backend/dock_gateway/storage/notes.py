"""Notes and tags on goals. Read from the database each time, so that every gateway that shares it has the same."""

from collections.abc import Collection
from dataclasses import dataclass
from datetime import datetime

import sqlalchemy as sa

from dock_gateway.core.errors import limit_reached
from dock_gateway.core.versions import UNCONDITIONAL, Condition, entity_tag
from dock_gateway.storage.immediate import ImmediateWriter
from dock_gateway.storage.reader import Reader
from dock_gateway.storage.tables import goal_notes, goal_tags, goals

MAX_NOTES = 100  # on one goal
MAX_TAGS_LISTED = 1000

# Built once, as each goal that is read asks for both: that takes longer than SQLite takes to run them.
_NOTES = (
    sa.select(
        goal_notes.c.goal_id, goal_notes.c.note_id, goal_notes.c.author, goal_notes.c.written_at, goal_notes.c.text
    )
    .where(goal_notes.c.goal_id.in_(sa.bindparam("goal_ids", expanding=True)))
    .order_by(goal_notes.c.written_at, goal_notes.c.note_id)
)
_TAGS = (
    sa.select(goal_tags)
    .where(goal_tags.c.goal_id.in_(sa.bindparam("goal_ids", expanding=True)))
    .order_by(goal_tags.c.tag)
)


@dataclass(frozen=True)
class Note:
    """A note on a goal."""

    id: str
    by: str
    created_at: datetime
    text: str


@dataclass(frozen=True)
class GoalNotes:
    """The tags of a goal, sorted, and its notes, oldest first."""

    tags: tuple[str, ...] = ()
    notes: tuple[Note, ...] = ()


class Notes:
    """Stores notes and tags of goals.

    Every method raises `Unavailable` (`history_unavailable`) if the database does not answer in time; nothing has
    changed then.

    Args:
        reader: Reads from the database.
        writer: Writes to it.
    """

    def __init__(self, reader: Reader, writer: ImmediateWriter) -> None:
        self._reader = reader
        self._writer = writer

    async def read(self, goal_ids: Collection[str]) -> dict[str, GoalNotes]:
        """Return the notes and tags of those of the goals that have any."""
        return await self._reader.read(_notes_of, goal_ids)

    async def tags_of(self, goal_ids: Collection[str]) -> dict[str, tuple[str, ...]]:
        """Return the tags of those of the goals that have any, sorted."""
        return await self._reader.read(_tags_of, goal_ids)

    async def all_tags(self) -> list[str]:
        """Return the tags of all goals, sorted."""
        return await self._reader.read(_all_tags)

    async def add(self, goal_id: str, note: Note) -> None:
        """Store a note.

        Raises:
            Conflict: The goal has too many notes (`limit_reached`).
        """
        await self._writer.write(_add, goal_id, note)

    async def remove(self, goal_id: str, note_id: str) -> None:
        """Delete a note, if the goal has it."""
        await self._writer.write(_remove, goal_id, note_id)

    async def replace_tags(self, goal_id: str, tags: Collection[str], condition: Condition = UNCONDITIONAL) -> None:
        """Store the tags of a goal.

        Raises:
            ChangedMeanwhile: They have not the version of the condition.
        """
        await self._writer.write(_replace_tags, goal_id, tags, condition)


def etag_of(tags: Collection[str]) -> str:
    """Return the entity tag of the tags of a goal, also of none."""
    return entity_tag(sorted(tags))


def delete_of(connection: sa.Connection, goal_ids: Collection[str]) -> None:
    """Delete the notes and tags of goals."""
    for table in (goal_notes, goal_tags):
        connection.execute(sa.delete(table).where(table.c.goal_id.in_(list(goal_ids))))


def _notes_of(connection: sa.Connection, goal_ids: Collection[str]) -> dict[str, GoalNotes]:
    notes: dict[str, list[Note]] = {}
    for goal_id, *note in connection.execute(_NOTES, {"goal_ids": list(goal_ids)}):
        notes.setdefault(goal_id, []).append(Note(*note))
    tags = _tags_of(connection, goal_ids)
    return {goal_id: GoalNotes(tags.get(goal_id, ()), tuple(notes.get(goal_id, ()))) for goal_id in {*tags, *notes}}


def _tags_of(connection: sa.Connection, goal_ids: Collection[str]) -> dict[str, tuple[str, ...]]:
    found: dict[str, tuple[str, ...]] = {}
    for row in connection.execute(_TAGS, {"goal_ids": list(goal_ids)}):
        found[row.goal_id] = (*found.get(row.goal_id, ()), row.tag)
    return found


def _all_tags(connection: sa.Connection) -> list[str]:
    query = sa.select(goal_tags.c.tag).distinct().order_by(goal_tags.c.tag).limit(MAX_TAGS_LISTED)
    return list(connection.scalars(query))


def _add(connection: sa.Connection, goal_id: str, note: Note) -> None:
    _lock(connection, goal_id)
    query = sa.select(sa.func.count()).where(goal_notes.c.goal_id == goal_id)
    _require_room(connection.scalar(query) or 0)
    row = {"note_id": note.id, "author": note.by, "written_at": note.created_at, "text": note.text}
    connection.execute(sa.insert(goal_notes), row | {"goal_id": goal_id})


def _remove(connection: sa.Connection, goal_id: str, note_id: str) -> None:
    it = goal_notes.c.note_id == note_id, goal_notes.c.goal_id == goal_id
    connection.execute(sa.delete(goal_notes).where(*it))


def _replace_tags(connection: sa.Connection, goal_id: str, tags: Collection[str], condition: Condition) -> None:
    _lock(connection, goal_id)
    condition.require(etag_of(_tags_of(connection, [goal_id]).get(goal_id, ())))
    connection.execute(sa.delete(goal_tags).where(goal_tags.c.goal_id == goal_id))
    if tags:
        connection.execute(sa.insert(goal_tags), [{"goal_id": goal_id, "tag": tag} for tag in sorted(tags)])


def _lock(connection: sa.Connection, goal_id: str) -> None:
    """Let other gateways, and the retention, wait until the transaction ends. SQLite has only one writer anyway."""
    connection.execute(sa.select(goals.c.goal_id).where(goals.c.goal_id == goal_id).with_for_update())


def _require_room(notes: int) -> None:
    if notes >= MAX_NOTES:
        raise limit_reached(MAX_NOTES, "notes of this goal")
