"""What is asked of events, in SQL that SQLite and PostgreSQL share. Functions of a connection, for `Database`."""

from collections.abc import Collection
from typing import Any

import sqlalchemy as sa

from dock_gateway.events import FEEDBACK, KIND_AT, Event
from dock_gateway.history.rows import event_of
from dock_gateway.history.tables import events, horizons

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
