"""The order in which gateways that share a database publish.

A gateway publishes an event only up to an id that it was allowed: by a *turn*, a short transaction that also returns
the ends of goals that were stored since its last one. The end of a goal is stored with an id behind all that any
gateway was allowed. So nobody publishes a later id before it knows of the end, and a reader may resume anywhere.
"""

from dataclasses import replace
from typing import NamedTuple

import sqlalchemy as sa

from dock_gateway.core.event import KINDS, RESULT, Event, kind_of, restamped, stamp_of, time_id
from dock_gateway.core.goal import GoalStatus
from dock_gateway.storage import queries
from dock_gateway.storage.protocol import NEVER
from dock_gateway.storage.rows import Batch, event_of
from dock_gateway.storage.tables import REACHED, events, horizons

# How far a turn allows to go at least, in nanoseconds, if ids are ahead of the clock.
STEP = 1_000_000

# Built once: a gateway that publishes takes ten turns a second.
_REACHED = sa.select(horizons.c.event_id).where(horizons.c.topic == REACHED).with_for_update()
_REACH = sa.update(horizons).where(horizons.c.topic == REACHED).values(event_id=sa.bindparam("allowed"))
_BY_KEY = sa.select(events).where(events.c.key.in_(sa.bindparam("keys", expanding=True)))
_ENDS_AFTER = (
    sa.select(events)
    .where(
        events.c.id > sa.bindparam("after"),
        events.c.topic == "goals",
        sa.func.substr(events.c.key, 1, 2).in_([f"{KINDS[kind]}-" for kind in ("status", "result")]),
    )
    .order_by(events.c.id)
)


class Turn(NamedTuple):
    """What a gateway may do after its turn.

    Attributes:
        stored: The events of the batch as stored, by key: those of another gateway, if it was first.
        ends: The events of all ends of goals that were stored since the last turn, in order.
        allowed: Events with an id up to this may be published after them.
    """

    stored: dict[str, Event]
    ends: list[Event]
    allowed: str


def take_turn(connection: sa.Connection, batch: Batch, after: str | None, wanted_ns: int) -> Turn:
    """Store the ends of goals, and return what has happened since the last turn.

    Args:
        connection: A write transaction.
        batch: The goals, and the events of their ends, of which the ids are changed to later ones.
        after: What the last turn allowed; None: this is the first one.
        wanted_ns: The stamp up to which the gateway wants to publish, in nanoseconds.
    """
    reached = stamp_of(_lock(connection))
    keys = [event.key for event in batch.events]
    known = _by_key(connection, keys)
    stamps: dict[str | None, int] = {}
    new = []
    for event in batch.events:
        if event.key not in known:
            if event.goal_id not in stamps:
                reached = stamps[event.goal_id] = max(reached + 1, stamp_of(event.id or ""))
            new.append(restamped(event, stamps[event.goal_id]))
    last = {event.goal_id: event.id for event in new}
    for goal in batch.goals:
        goal.last_event_id = last.get(goal.goal_id, goal.last_event_id)
    if len(batch):
        queries.write(connection, Batch(goals=batch.goals, events=new))
    allowed = time_id(max(wanted_ns, reached + STEP))
    connection.execute(_REACH, {"allowed": allowed})
    ends = [] if after is None else _ends_after(connection, after)
    return Turn(_by_key(connection, keys), ends, allowed + NEVER)


def _lock(connection: sa.Connection) -> str:
    """Return the id up to which gateways may have published; no other one has a turn until the transaction ends."""
    if (found := connection.scalar(_REACHED)) is None:
        first = {"topic": REACHED, "event_id": queries.newest(connection) or time_id(0)}
        connection.execute(queries.insert_into(connection.dialect.name, horizons).on_conflict_do_nothing(), first)
        found = connection.scalar(_REACHED)
    return str(found)


def _by_key(connection: sa.Connection, keys: list[str | None]) -> dict[str, Event]:
    if not keys:
        return {}
    return {row["key"]: event_of(row) for row in connection.execute(_BY_KEY, {"keys": keys}).mappings()}


def _ends_after(connection: sa.Connection, after: str) -> list[Event]:
    return [_with_end(event_of(row)) for row in connection.execute(_ENDS_AFTER, {"after": after}).mappings()]


def _with_end(event: Event) -> Event:
    """Return an event of an end with `ends_goal`, which is not stored: a rejected goal has no result."""
    rejected = b'"status":"%s"' % GoalStatus.REJECTED.value.encode()
    return replace(event, ends_goal=kind_of(event.id or "") == RESULT or rejected in event.data)
