"""Statements that write and read goals, events and keys, in SQL that SQLite and PostgreSQL share.

Each function takes a connection, as `Database` expects.
"""

import importlib
from collections.abc import Collection, Iterable, Sequence
from datetime import UTC, datetime
from functools import cache
from typing import TYPE_CHECKING, Any

import sqlalchemy as sa

from dock_gateway.core.cursor import Cursor
from dock_gateway.core.event import FEEDBACK, KIND_AT, NEVER, Event
from dock_gateway.core.filters import GoalFilter
from dock_gateway.core.goal import Goal, GoalStatus
from dock_gateway.storage.merge import merge, merge_all
from dock_gateway.storage.rows import Batch, Key, event_of, event_row, goal_of, goal_row, key_row
from dock_gateway.storage.tables import REACHED, events, goal_tags, goals, horizons, idempotency_keys

if TYPE_CHECKING:
    from sqlalchemy.dialects import postgresql, sqlite

_FINAL = [status.value for status in GoalStatus if status.final]


def insert_into(dialect_name: str, table: sa.Table) -> "postgresql.Insert | sqlite.Insert":
    """Return an insert that supports `ON CONFLICT`."""
    # Only the dialect in use is loaded; the other would add a tenth to the start time.
    dialect = importlib.import_module(f"sqlalchemy.dialects.{dialect_name}")
    insert: postgresql.Insert | sqlite.Insert = dialect.insert(table)
    return insert


# The statements that a submitted goal waits for are built once: that takes longer than SQLite takes to run them.
_GOALS_BY_ID = (
    sa.select(goals).where(goals.c.goal_id.in_(sa.bindparam("goal_ids", expanding=True))).order_by(goals.c.goal_id)
)
_LOCKED_GOALS_BY_ID = _GOALS_BY_ID.with_for_update()
_EVENTS_BY_KEY = sa.select(events).where(events.c.key.in_(sa.bindparam("keys", expanding=True)))
_UPDATE_GOAL = sa.update(goals).where(goals.c.goal_id == sa.bindparam("this_goal"))


@cache
def _insert_new_goals(dialect_name: str) -> "sa.Executable":
    """Return an insert of the goals that are not stored yet, which returns their ids."""
    return insert_into(dialect_name, goals).on_conflict_do_nothing().returning(goals.c.goal_id)


@cache
def _insert_new_events(dialect_name: str) -> "sa.Executable":
    """Return an insert of the events that are not stored yet."""
    return insert_into(dialect_name, events).on_conflict_do_nothing()


# ---------------------------------------------------------------------- write


def write(connection: sa.Connection, batch: Batch) -> None:
    """Write a batch; idempotent. Rows are written in a fixed order, so that writers do not deadlock."""
    if batch.keys:
        for key in sorted(batch.keys, key=lambda key: key.key):
            claim(connection, key)
    if batch.events:
        rows = sorted(map(event_row, batch.events), key=lambda row: (str(row["key"]), str(row["id"])))
        connection.execute(_insert_new_events(connection.dialect.name), rows)
    if batch.gaps:
        raise_horizons(connection, batch.gaps)
    if batch.goals:  # last: these locks block other gateways that write the same goals until the commit
        _write_goals(connection, {goal.goal_id: goal for goal in batch.goals})


def seal(connection: sa.Connection, batch: Batch) -> dict[str, Event]:
    """Write a batch; return its events as stored, by key: those of another gateway, if it was first."""
    write(connection, batch)
    if not batch.events:
        return {}
    result = connection.execute(_EVENTS_BY_KEY, {"keys": [event.key for event in batch.events]})
    return {row["key"]: event_of(row) for row in result.mappings()}


def _write_goals(connection: sa.Connection, news: dict[str, Goal]) -> None:
    rows = [goal_row(goal) for _, goal in sorted(news.items())]
    inserted = set(connection.execute(_insert_new_goals(connection.dialect.name), rows).scalars())
    if len(inserted) == len(news):
        return
    stored = goals_by_id(connection, news.keys() - inserted, lock=True)
    merged = [merge(stored[goal_id], news[goal_id]) for goal_id in sorted(stored)]
    changes = [row for goal in merged if (row := goal_row(goal)) != goal_row(stored[goal.goal_id])]
    if changes:
        connection.execute(_UPDATE_GOAL, [row | {"this_goal": row["goal_id"]} for row in changes])


def claim(connection: sa.Connection, key: Key) -> Key:
    """Bind the key to its goal unless another goal holds it; return the key that is stored."""
    insert = insert_into(connection.dialect.name, idempotency_keys)
    row = key_row(key)
    statement = insert.on_conflict_do_update(
        index_elements=["key"], set_=row, where=idempotency_keys.c.expires_at <= datetime.now(UTC)
    )
    connection.execute(statement, row)
    return key_of(connection, key.key) or key


def release(connection: sa.Connection, key: str, goal_id: str) -> None:
    """Release the key if this goal holds it."""
    is_it = (idempotency_keys.c.key == key, idempotency_keys.c.goal_id == goal_id)
    connection.execute(sa.delete(idempotency_keys).where(*is_it))


def raise_horizons(connection: sa.Connection, gaps: dict[str, str]) -> None:
    """Store the id of the newest missing event of each topic."""
    insert = insert_into(connection.dialect.name, horizons)
    statement = insert.on_conflict_do_update(
        index_elements=["topic"],
        set_={"event_id": insert.excluded.event_id},
        where=insert.excluded.event_id > horizons.c.event_id,
    )
    for topic, event_id in sorted(gaps.items()):
        connection.execute(statement, {"topic": topic, "event_id": event_id})


# ---------------------------------------------------------------------- read


def goals_by_id(connection: sa.Connection, goal_ids: Iterable[str], *, lock: bool = False) -> dict[str, Goal]:
    """Return the stored goals among these ids."""
    query = _LOCKED_GOALS_BY_ID if lock else _GOALS_BY_ID
    result = connection.execute(query, {"goal_ids": list(goal_ids)})
    return {row["goal_id"]: goal_of(row) for row in result.mappings()}


def page(
    connection: sa.Connection,
    wanted: GoalFilter,
    *,
    limit: int,
    before: Cursor | None,
    without: Sequence[str],
) -> list[Goal]:
    """Return goals, newest first; `before` is an exclusive bound of time and id."""
    query = sa.select(goals).order_by(goals.c.created_at.desc(), goals.c.goal_id.desc()).limit(limit)
    query = query.where(*conditions(wanted))
    if without:
        query = query.where(goals.c.goal_id.not_in(without))
    if before is not None:
        time, goal_id = sa.literal(before[0], goals.c.created_at.type), sa.literal(before[1], goals.c.goal_id.type)
        query = query.where(sa.tuple_(goals.c.created_at, goals.c.goal_id) < sa.tuple_(time, goal_id))
    return [goal_of(row) for row in connection.execute(query).mappings()]


def conditions(wanted: GoalFilter) -> "list[sa.ColumnElement[bool]]":
    """Return `GoalFilter.matches` as SQL conditions."""
    found = _on_actions(wanted)
    if wanted.statuses:
        found.append(goals.c.status.in_(sorted(status.value for status in wanted.statuses)))
    if wanted.error_codes:
        found.append(goals.c.error_code.in_(sorted(wanted.error_codes)))
    if wanted.origin is not None:
        found.append(goals.c.origin == wanted.origin)
    if wanted.verb is not None:
        found.append(goals.c.verb == wanted.verb)
    if wanted.since is not None:
        found.append(goals.c.created_at >= wanted.since)
    if wanted.until is not None:
        found.append(goals.c.created_at < wanted.until)
    if wanted.tags:
        found.append(goals.c.goal_id.in_(tagged(wanted.tags)))
    if wanted.id_prefix:  # a range of the primary key, as LIKE would not use it
        beyond = wanted.id_prefix[:-1] + chr(ord(wanted.id_prefix[-1]) + 1)
        found += [goals.c.goal_id >= wanted.id_prefix, goals.c.goal_id < beyond]
    return found


def _on_actions(wanted: GoalFilter) -> "list[sa.ColumnElement[bool]]":
    found: list[sa.ColumnElement[bool]] = []
    if wanted.action_names:
        found.append(goals.c.action_name.in_(sorted(wanted.action_names)))
    if wanted.prefix != "/":  # not LIKE, which ignores case in SQLite
        inside = sa.func.substr(goals.c.action_name, 1, len(wanted.prefix)) == wanted.prefix
        found.append(sa.or_(inside, goals.c.action_name.in_(sorted(wanted.homed))) if wanted.homed else inside)
    if wanted.among is not None:
        found.append(goals.c.action_name.in_(sorted(wanted.among)))
    return found


def tagged(tags: Collection[str]) -> "sa.Select[tuple[str]]":
    """Return a query for the ids of the goals that have one of these tags."""
    return sa.select(goal_tags.c.goal_id).where(goal_tags.c.tag.in_(sorted(tags)))


def page_with_waiting(
    connection: sa.Connection, wanted: GoalFilter, waiting: dict[str, Goal], *, limit: int, before: Cursor | None
) -> list[Goal]:
    """Return a page of stored and pending goals, newest first."""
    stored = goals_by_id(connection, list(waiting))
    known = {**stored, **merge_all(stored, waiting)}
    found = page(connection, wanted, limit=limit, before=before, without=list(waiting))
    candidates = list(waiting)
    if wanted.tags and waiting:
        query = tagged(wanted.tags).where(goal_tags.c.goal_id.in_(candidates))
        candidates = list(connection.scalars(query.distinct()))
    found += [
        known[goal_id]
        for goal_id in candidates
        if wanted.matches(known[goal_id]) and (before is None or cursor_of(known[goal_id]) < before)
    ]
    return sorted(found, key=cursor_of, reverse=True)[:limit]


def unfinished_or(connection: sa.Connection, goal_ids: Collection[str]) -> dict[str, Goal]:
    """Return the unfinished goals and the goals with these ids, to go on with those that have not ended."""
    found = {goal.goal_id: goal for goal in unfinished(connection)} | goals_by_id(connection, goal_ids)
    return _counted(connection, found)


def goals_to_follow(connection: sa.Connection, goal_ids: Collection[str]) -> dict[str, Goal]:
    """Return the stored goals among these ids, to go on with those that have not ended."""
    return _counted(connection, goals_by_id(connection, goal_ids))


def _counted(connection: sa.Connection, found: dict[str, Goal]) -> dict[str, Goal]:
    """Count the feedback of those that have not ended: who was killed has stored the events, but not how many."""
    for goal in found.values():
        if not goal.status.final:
            goal.feedback_count = max(goal.feedback_count, feedback_of_goal(connection, goal.goal_id, NEVER)[0])
    return found


def cursor_of(goal: Goal) -> Cursor:
    """Return the place of a goal in lists."""
    return Cursor(goal.created_at, goal.goal_id)


# Reads an index once for each name: DISTINCT would read it all.
_ACTION_NAMES = sa.text(
    "WITH RECURSIVE names (name) AS ("
    "SELECT min(action_name) FROM goals UNION ALL "
    "SELECT (SELECT min(action_name) FROM goals WHERE action_name > name) FROM names WHERE name IS NOT NULL"
    ") SELECT name FROM names WHERE name IS NOT NULL"
)


def action_names(connection: sa.Connection) -> set[str]:
    """Return the names of the actions that have goals."""
    return set(connection.scalars(_ACTION_NAMES))


def unfinished(connection: sa.Connection) -> list[Goal]:
    """Return the goals that are not in a final state."""
    open_statuses = [status.value for status in GoalStatus if status.value not in _FINAL]
    query = sa.select(goals).where(goals.c.status.in_(open_statuses))
    return [goal_of(row) for row in connection.execute(query).mappings()]


def key_of(connection: sa.Connection, key: str) -> Key | None:
    """Return a key unless it has expired."""
    keys = _keys(connection, idempotency_keys.c.key == key, limit=1)
    return keys[0] if keys else None


def newest_keys(connection: sa.Connection, limit: int) -> list[Key]:
    """Return the keys that expire last."""
    return _keys(connection, sa.true(), limit=limit)


def _keys(connection: sa.Connection, condition: "sa.ColumnElement[bool]", limit: int) -> list[Key]:
    query = (
        sa.select(idempotency_keys)
        .where(condition, idempotency_keys.c.expires_at > datetime.now(UTC))
        .order_by(idempotency_keys.c.expires_at.desc())
        .limit(limit)
    )
    return [Key(**row) for row in connection.execute(query).mappings()]


_KIND = sa.func.substr(events.c.id, KIND_AT + 1, 1)


def is_complete_after(connection: sa.Connection, event_id: str, topics: Collection[str], *, reaches_back: bool) -> bool:
    """Return whether no event after `event_id` was dropped, and the history reaches back to it.

    It reaches back if an older event is stored, if an older event was dropped, or if the tables are older. That is not
    checked if `reaches_back` is set.
    """
    of_topics = horizons.c.topic.in_(list(topics))
    if connection.scalar(sa.select(sa.exists().where(of_topics, horizons.c.event_id > event_id))):
        return False
    return reaches_back or bool(
        connection.scalar(
            sa.select(
                sa.or_(
                    sa.exists().where(events.c.id <= event_id),
                    sa.exists().where(horizons.c.event_id <= event_id, horizons.c.topic != REACHED),
                )
            )
        )
    )


def newest(connection: sa.Connection) -> str:
    """Return the id of the newest event, empty if there is none."""
    return connection.scalar(sa.select(sa.func.max(events.c.id))) or ""


def events_after(
    connection: sa.Connection,
    event_id: str,
    *,
    goal_id: str | None,
    action_name: str | None,
    topics: Collection[str],
    limit: int,
) -> list[Event]:
    """Return the events after a given id, ordered by id."""
    wanted: list[Any] = []
    if goal_id is not None:
        wanted.append(events.c.goal_id == goal_id)
    if action_name is not None:
        wanted.append(events.c.action_name == action_name)
    query = (
        sa.select(events)
        .where(
            events.c.id > event_id,
            events.c.topic.in_(list(topics)),
            sa.or_(events.c.topic != "goals", sa.and_(sa.true(), *wanted)),
        )
        .order_by(events.c.id)
        .limit(limit)
    )
    return [event_of(row) for row in connection.execute(query).mappings()]


def events_of_goal(
    connection: sa.Connection, goal_id: str, *, kinds: Collection[str], after: str, until: str, limit: int
) -> list[Event]:
    """Return the events of a goal from `after` (exclusive) to `until` (inclusive), ordered by id."""
    query = (
        sa.select(events)
        .where(events.c.goal_id == goal_id, events.c.id > after, events.c.id <= until, _KIND.in_(sorted(kinds)))
        .order_by(events.c.id)
        .limit(limit)
    )
    return [event_of(row) for row in connection.execute(query).mappings()]


def first_of_goal(connection: sa.Connection, goal_id: str) -> str | None:
    """Return the id of the first stored event of a goal."""
    first: str | None = connection.scalar(sa.select(sa.func.min(events.c.id)).where(events.c.goal_id == goal_id))
    return first


def feedback_of_goal(connection: sa.Connection, goal_id: str, until: str) -> tuple[int, set[str]]:
    """Return the number of feedback events of a goal before `until`, and the ids of the rest."""
    ids = sa.select(events.c.id).where(events.c.goal_id == goal_id, _KIND == FEEDBACK)
    count = connection.scalar(sa.select(sa.func.count()).select_from(ids.where(events.c.id < until).subquery()))
    return count or 0, set(connection.scalars(ids.where(events.c.id >= until)))


def horizon(connection: sa.Connection, topic: str) -> str:
    """Return the id of the newest missing event of a topic, empty if there is none."""
    return connection.scalar(sa.select(horizons.c.event_id).where(horizons.c.topic == topic)) or ""
