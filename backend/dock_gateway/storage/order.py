"""The order in which gateways that share a database publish.

A gateway publishes an event only up to an id that it was allowed: by a *turn*, a short transaction that also returns
the states and results of goals that any gateway has stored since its last one. Each of them is stored with an id behind
all that any gateway was allowed. So no gateway publishes a later id before it knows of them, and a reader may resume
anywhere.
"""

from dataclasses import replace
from typing import NamedTuple

import orjson
import sqlalchemy as sa

from dock_gateway.core.event import KIND_AT, NEVER, RESULT, STATUS, Event, is_end, kind_of, restamped, stamp_of, time_id
from dock_gateway.core.goal import GoalStatus
from dock_gateway.storage import queries
from dock_gateway.storage.merge import RANK
from dock_gateway.storage.rows import Batch, event_of
from dock_gateway.storage.tables import REACHED, events, horizons

# How far a turn allows to go at least, in nanoseconds, if ids are ahead of the clock.
STEP = 1_000_000

# Events as they are stored, by key; None for one that is not stored, as another gateway has made it outdated.
Stored = dict[str, Event | None]

_LOST = b'"status":"%s"' % GoalStatus.LOST.value.encode()

# Built once: a gateway that publishes takes ten turns a second.
_KIND = sa.func.substr(events.c.id, KIND_AT + 1, 1)
_REACHED = sa.select(horizons.c.event_id).where(horizons.c.topic == REACHED).with_for_update()
_REACH = sa.update(horizons).where(horizons.c.topic == REACHED).values(event_id=sa.bindparam("allowed"))
_BY_KEY = sa.select(events).where(events.c.key.in_(sa.bindparam("keys", expanding=True)))
_AFTER = (
    sa.select(events)
    .where(events.c.id > sa.bindparam("after"), events.c.topic == "goals", _KIND.in_([STATUS, RESULT]))
    .order_by(events.c.id)
)
_LAST_STATE = (
    sa.select(events)
    .where(events.c.goal_id == sa.bindparam("goal_id"), events.c.topic == "goals", _KIND == STATUS)
    .order_by(events.c.id.desc())
    .limit(1)
)


class Turn(NamedTuple):
    """The result of a gateway's turn.

    Attributes:
        stored: The events of the batch as stored: those of another gateway, if it was first.
        events: The states and results of all goals that were stored since the last turn, in order.
        allowed: Events with an id up to this may be published after them.
    """

    stored: Stored
    events: list[Event]
    allowed: str


def take_turn(connection: sa.Connection, batch: Batch, after: str | None, wanted_ns: int) -> Turn:
    """Store states and results of goals, and return what has happened since the last turn.

    Args:
        connection: A write transaction.
        batch: The goals, and events of them in their order, whose ids are changed to later ones.
        after: What the last turn allowed; None: this is the first one.
        wanted_ns: The stamp up to which the gateway wants to publish, in nanoseconds.
    """
    reached = stamp_of(_lock(connection))
    stored: Stored = {**_by_key(connection, [event.key for event in batch.events])}
    states: dict[str | None, Event | None] = {}  # the last one of each goal
    new: list[Event] = []
    for event in batch.events:
        key, goal_id = event.key or "", event.goal_id
        if key in stored:
            continue
        if goal_id not in states:
            states[goal_id] = _last_state(connection, goal_id)
        if not is_end(event) and (last := states[goal_id]) is not None and _is_outdated(event, last):
            stored[key] = None
            continue
        if not (kind_of(event.id or "") == RESULT and new and new[-1].goal_id == goal_id):
            reached = max(reached + 1, stamp_of(event.id or ""))  # a result has the stamp of the state before it
        new.append(restamped(event, reached))
        stored[key] = new[-1]
        if kind_of(event.id or "") == STATUS:
            states[goal_id] = new[-1]
    newest = {event.goal_id: event.id for event in new}
    for goal in batch.goals:
        goal.last_event_id = newest.get(goal.goal_id, goal.last_event_id)
    if len(batch):
        queries.write(connection, Batch(goals=batch.goals, events=new))
    allowed = time_id(max(wanted_ns, reached + STEP))
    connection.execute(_REACH, {"allowed": allowed})
    return Turn(stored, [] if after is None else _after(connection, after), allowed + NEVER)


def _is_outdated(event: Event, last: Event) -> bool:
    """Return whether a state says nothing new after the last one of its goal, which another gateway may have stored."""
    if is_end(last):
        return True
    new, old = (orjson.loads(each.data) for each in (event, last))
    if old["status"] != GoalStatus.LOST and RANK[new["status"]] < RANK[old["status"]]:
        return True
    names = ("status", "stalled", "origin", "stage", "retries")
    return all(new[name] == old[name] for name in names)


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


def _last_state(connection: sa.Connection, goal_id: str | None) -> Event | None:
    row = connection.execute(_LAST_STATE, {"goal_id": goal_id}).mappings().first()
    return None if row is None else event_of(row)


def _after(connection: sa.Connection, after: str) -> list[Event]:
    return [_with_end(event_of(row)) for row in connection.execute(_AFTER, {"after": after}).mappings()]


def _with_end(event: Event) -> Event:
    """Return an event with `ends_goal`, which is not stored: those of a goal end with its result, or as it is lost."""
    ends = kind_of(event.id or "") == RESULT
    if not ends and _LOST in event.data:
        ends = orjson.loads(event.data)["status"] == GoalStatus.LOST
    return replace(event, ends_goal=ends)
