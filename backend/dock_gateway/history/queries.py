"""What is written, and what is asked of goals and keys, in SQL that SQLite and PostgreSQL share.

Functions of a connection, for `Database`.
"""

import importlib
from collections.abc import Collection, Iterable, Sequence
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any

import sqlalchemy as sa

from dock_gateway.core.event import FEEDBACK, KIND_AT, Event
from dock_gateway.core.filters import GoalFilter
from dock_gateway.core.goal import Goal, GoalStatus
from dock_gateway.history.merge import merge
from dock_gateway.history.rows import Batch, Key, event_of, event_row, goal_of, goal_row, key_row
from dock_gateway.history.tables import events, goals, horizons, idempotency_keys

if TYPE_CHECKING:
    from sqlalchemy.dialects import postgresql, sqlite

_FINAL = [status.value for status in GoalStatus if status.final]


def insert_into(connection: sa.Connection, table: sa.Table) -> "postgresql.Insert | sqlite.Insert":
    """An insert that can say what to do where there is such a row already."""
    # Only the dialect in use is loaded; the other one would cost a tenth of the start.
    dialect = importlib.import_module(f"sqlalchemy.dialects.{connection.dialect.name}")
    insert: postgresql.Insert | sqlite.Insert = dialect.insert(table)
    return insert


# ---------------------------------------------------------------------- write


def write(connection: sa.Connection, batch: Batch) -> None:
    """Write a batch; doing so again changes nothing. Rows are taken in one order, so that writers do not lock up."""
    if batch.keys:
        for key in sorted(batch.keys, key=lambda key: key.key):
            claim(connection, key)
    if batch.events:
        rows = sorted(map(event_row, batch.events), key=lambda row: (str(row["key"]), str(row["id"])))
        connection.execute(insert_into(connection, events).on_conflict_do_nothing(), rows)
    if batch.gaps:
        raise_horizons(connection, batch.gaps)
    if batch.goals:  # last: another gateway that has news of a goal waits until this transaction has ended
        _write_goals(connection, {goal.goal_id: goal for goal in batch.goals})


def seal(connection: sa.Connection, batch: Batch) -> dict[str, Event]:
    """Write a batch; returns its events as they are stored, by key: those of another gateway, where that was first."""
    write(connection, batch)
    if not batch.events:
        return {}
    query = sa.select(events).where(events.c.key.in_([event.key for event in batch.events]))
    return {row["key"]: event_of(row) for row in connection.execute(query).mappings()}


def _write_goals(connection: sa.Connection, news: dict[str, Goal]) -> None:
    rows = [goal_row(goal) for _, goal in sorted(news.items())]
    statement = insert_into(connection, goals).on_conflict_do_nothing().returning(goals.c.goal_id)
    inserted = set(connection.execute(statement, rows).scalars())
    if len(inserted) == len(news):
        return
    stored = goals_by_id(connection, news.keys() - inserted, lock=True)
    merged = [merge(stored[goal_id], news[goal_id]) for goal_id in sorted(stored)]
    changes = [row for goal in merged if (row := goal_row(goal)) != goal_row(stored[goal.goal_id])]
    if changes:
        change = sa.update(goals).where(goals.c.goal_id == sa.bindparam("this_goal"))
        connection.execute(
            change.values({name: sa.bindparam(f"new_{name}") for name in changes[0]}),
            [{f"new_{name}": value for name, value in row.items()} | {"this_goal": row["goal_id"]} for row in changes],
        )


def claim(connection: sa.Connection, key: Key) -> Key:
    """Give the key to the goal, unless another goal has it; whose it is."""
    insert = insert_into(connection, idempotency_keys)
    row = key_row(key)
    statement = insert.on_conflict_do_update(
        index_elements=["key"], set_=row, where=idempotency_keys.c.expires_at <= datetime.now(UTC)
    )
    connection.execute(statement, row)
    return key_of(connection, key.key) or key


def release(connection: sa.Connection, key: str, goal_id: str) -> None:
    """Let go of the key of a goal."""
    is_it = (idempotency_keys.c.key == key, idempotency_keys.c.goal_id == goal_id)
    connection.execute(sa.delete(idempotency_keys).where(*is_it))


def raise_horizons(connection: sa.Connection, gaps: dict[str, str]) -> None:
    """Note the newest events that are missing."""
    insert = insert_into(connection, horizons)
    statement = insert.on_conflict_do_update(
        index_elements=["topic"],
        set_={"event_id": insert.excluded.event_id},
        where=insert.excluded.event_id > horizons.c.event_id,
    )
    for topic, event_id in sorted(gaps.items()):
        connection.execute(statement, {"topic": topic, "event_id": event_id})


# ---------------------------------------------------------------------- read


def goals_by_id(connection: sa.Connection, goal_ids: Iterable[str], *, lock: bool = False) -> dict[str, Goal]:
    """The goals with these ids, as far as there are any."""
    query = sa.select(goals).where(goals.c.goal_id.in_(list(goal_ids))).order_by(goals.c.goal_id)
    result = connection.execute(query.with_for_update() if lock else query)
    return {row["goal_id"]: goal_of(row) for row in result.mappings()}


def page(
    connection: sa.Connection,
    wanted: GoalFilter,
    *,
    limit: int,
    before: tuple[datetime, str] | None,
    without: Sequence[str],
) -> list[Goal]:
    """Goals, newest first, those `before` a time and an id."""
    query = sa.select(goals).order_by(goals.c.created_at.desc(), goals.c.goal_id.desc()).limit(limit)
    query = query.where(*_conditions(wanted))
    if without:
        query = query.where(goals.c.goal_id.not_in(without))
    if before is not None:
        time, goal_id = sa.literal(before[0], goals.c.created_at.type), sa.literal(before[1], goals.c.goal_id.type)
        query = query.where(sa.tuple_(goals.c.created_at, goals.c.goal_id) < sa.tuple_(time, goal_id))
    return [goal_of(row) for row in connection.execute(query).mappings()]


def _conditions(wanted: GoalFilter) -> "list[sa.ColumnElement[bool]]":
    """What `GoalFilter.matches` says, in SQL."""
    conditions: list[sa.ColumnElement[bool]] = []
    if wanted.action_names:
        conditions.append(goals.c.action_name.in_(sorted(wanted.action_names)))
    if wanted.prefix != "/":  # not by LIKE, to which upper and lower case are one in SQLite
        conditions.append(sa.func.substr(goals.c.action_name, 1, len(wanted.prefix)) == wanted.prefix)
    if wanted.statuses:
        conditions.append(goals.c.status.in_(sorted(status.value for status in wanted.statuses)))
    if wanted.origin is not None:
        conditions.append(goals.c.origin == wanted.origin)
    if wanted.since is not None:
        conditions.append(goals.c.created_at >= wanted.since)
    if wanted.until is not None:
        conditions.append(goals.c.created_at < wanted.until)
    return conditions


def unfinished(connection: sa.Connection) -> list[Goal]:
    """The goals that are not in a final state."""
    open_statuses = [status.value for status in GoalStatus if status.value not in _FINAL]
    query = sa.select(goals).where(goals.c.status.in_(open_statuses))
    return [goal_of(row) for row in connection.execute(query).mappings()]


def key_of(connection: sa.Connection, key: str) -> Key | None:
    """A key that has not expired."""
    keys = _keys(connection, idempotency_keys.c.key == key, limit=1)
    return keys[0] if keys else None


def newest_keys(connection: sa.Connection, limit: int) -> list[Key]:
    """The keys that expire last."""
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
    """Whether nothing that followed an event was given up, and the past reaches back to it (if not known already).

    It does where something older is kept, where something older was given up, or where the tables are older.
    """
    of_topics = horizons.c.topic.in_(list(topics))
    if connection.scalar(sa.select(sa.exists().where(of_topics, horizons.c.event_id > event_id))):
        return False
    return reaches_back or bool(
        connection.scalar(
            sa.select(
                sa.or_(sa.exists().where(events.c.id <= event_id), sa.exists().where(horizons.c.event_id <= event_id))
            )
        )
    )


def newest(connection: sa.Connection) -> str:
    """The id of the newest event."""
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
    """The events that follow one, in the order of their ids."""
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
    """The events of a goal after one and up to another, in the order of their ids."""
    query = (
        sa.select(events)
        .where(events.c.goal_id == goal_id, events.c.id > after, events.c.id <= until, _KIND.in_(sorted(kinds)))
        .order_by(events.c.id)
        .limit(limit)
    )
    return [event_of(row) for row in connection.execute(query).mappings()]


def first_of_goal(connection: sa.Connection, goal_id: str) -> str | None:
    """The id of the first event of a goal that is there."""
    first: str | None = connection.scalar(sa.select(sa.func.min(events.c.id)).where(events.c.goal_id == goal_id))
    return first


def feedback_of_goal(connection: sa.Connection, goal_id: str, until: str) -> tuple[int, set[str]]:
    """How many feedback events of a goal there are before an event, and the ids of those that follow."""
    ids = sa.select(events.c.id).where(events.c.goal_id == goal_id, _KIND == FEEDBACK)
    count = connection.scalar(sa.select(sa.func.count()).select_from(ids.where(events.c.id < until).subquery()))
    return count or 0, set(connection.scalars(ids.where(events.c.id >= until)))


def horizon(connection: sa.Connection, topic: str) -> str:
    """The id of the newest event of a topic that is missing."""
    return connection.scalar(sa.select(horizons.c.event_id).where(horizons.c.topic == topic)) or ""
