"""Goals, events and keys as rows of a table, and as lines of the spool."""

import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import Any

import orjson

from dock_gateway.core.event import Event
from dock_gateway.core.goal import Goal, GoalError, GoalStatus

Row = dict[str, Any]

# Written in one transaction at most: so many goals, and so many events.
BATCH_GOALS = 200
BATCH_EVENTS = 1000

_TIMES = ("created_at", "updated_at", "finished_at")
# What a line of an older version does not have.
_NEW = {"stage": None, "retries": None}
_MESSAGES = ("goal", "feedback", "result")


@dataclass(frozen=True)
class Key:
    """An idempotency key and the goal that it stands for."""

    key: str
    goal_id: str
    fingerprint: str
    expires_at: datetime

    @property
    def expired(self) -> bool:
        """Whether another goal may have the key."""
        return self.expires_at <= datetime.now(UTC)


@dataclass
class Batch:
    """What is written in one transaction. `gaps` are the newest events of a topic that were given up."""

    goals: list[Goal] = field(default_factory=list)
    events: list[Event] = field(default_factory=list)
    keys: list[Key] = field(default_factory=list)
    gaps: dict[str, str] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.goals) + len(self.events) + len(self.keys) + len(self.gaps)

    @property
    def full(self) -> bool:
        """Whether more may be waiting."""
        return len(self.goals) >= BATCH_GOALS or len(self.keys) >= BATCH_GOALS or len(self.events) >= BATCH_EVENTS

    @property
    def must_keep(self) -> bool:
        """Whether there is anything that a power cut must not take."""
        return bool(self.goals or self.keys or any(not event.droppable for event in self.events))

    def split(self) -> "list[Batch]":
        """Each part alone, to find out which of them the database refuses."""
        return [
            *(Batch(goals=[goal]) for goal in self.goals),
            *(Batch(events=[event]) for event in self.events),
            *(Batch(keys=[key]) for key in self.keys),
            *(Batch(gaps={topic: event_id}) for topic, event_id in self.gaps.items()),
        ]


def goal_row(goal: Goal) -> Row:
    """A goal as the table has it."""
    error = goal.error
    return {
        "goal_id": goal.goal_id,
        "action_name": goal.action_name,
        "action_type": goal.action_type,
        "origin": goal.origin,
        "status": goal.status.value,
        "stalled": goal.stalled,
        "goal": goal.goal,
        "feedback": goal.feedback,
        "result": goal.result,
        "error_code": error and error.code,
        "error_detail": error and _storable(error.detail),
        "stage": goal.stage and _storable(goal.stage),
        "retries": goal.retries,
        "created_at": goal.created_at,
        "updated_at": goal.updated_at,
        "finished_at": goal.finished_at,
        "feedback_count": goal.feedback_count,
        "last_event_id": goal.last_event_id,
    }


def goal_of(row: Mapping[Any, Any]) -> Goal:
    """The goal in a row."""
    goal = Goal(
        goal_id=row["goal_id"],
        action_name=row["action_name"],
        action_type=row["action_type"],
        created_at=row["created_at"],
        origin=row["origin"],
        status=GoalStatus(row["status"]),
        goal=row["goal"],
        feedback=row["feedback"],
        result=row["result"],
        error=GoalError(row["error_code"], row["error_detail"] or "") if row["error_code"] else None,
        stage=row["stage"],
        retries=row["retries"],
        stalled=row["stalled"],
        finished_at=row["finished_at"],
        feedback_count=row["feedback_count"],
        last_event_id=row["last_event_id"],
    )
    goal.updated_at = row["updated_at"]
    return goal


def event_row(event: Event) -> Row:
    """An event as the table has it."""
    return {
        "id": event.id,
        "topic": event.topic,
        "goal_id": event.goal_id,
        "action_name": event.action_name,
        "robot": event.robot,
        "droppable": event.droppable,
        "size": len(event.data),
        "data": event.data,
        "key": event.key,
    }


def event_of(row: Mapping[Any, Any]) -> Event:
    """The event in a row."""
    return Event(
        row["data"],
        row["topic"],
        row["goal_id"],
        row["action_name"],
        row["droppable"],
        id=row["id"],
        robot=row["robot"],
        key=row.get("key"),  # a spool of before has none
    )


def key_row(key: Key) -> Row:
    """A key as the table has it."""
    return {"key": key.key, "goal_id": key.goal_id, "fingerprint": key.fingerprint, "expires_at": key.expires_at}


def line_of(entry: Goal | Event | Key) -> bytes:
    """One line of the spool: a checksum, then JSON."""
    kind, row = (
        ("goal", goal_row(entry))
        if isinstance(entry, Goal)
        else ("event", event_row(entry))
        if isinstance(entry, Event)
        else ("key", key_row(entry))
    )
    texts = {name: value.decode() if isinstance(value, bytes) else value for name, value in row.items()}
    body = orjson.dumps({kind: texts})
    return b"%08x %s\n" % (zlib.crc32(body), body)


def entry_of(line: bytes) -> Goal | Event | Key:
    """What a line of the spool holds.

    Raises:
        ValueError: The line is damaged.
    """
    checksum, _, body = line.rstrip(b"\n").partition(b" ")
    if int(checksum, 16) != zlib.crc32(body):
        raise ValueError("the checksum is wrong")
    ((kind, row),) = orjson.loads(body).items()
    try:
        if kind == "goal":
            times = {name: row[name] and datetime.fromisoformat(row[name]) for name in _TIMES}
            messages = {name: row[name] if row[name] is None else row[name].encode() for name in _MESSAGES}
            return goal_of(_NEW | row | times | messages)
        if kind == "event":
            return event_of(row | {"data": row["data"].encode()})
        return Key(**row | {"expires_at": datetime.fromisoformat(row["expires_at"])})
    except (KeyError, TypeError, AttributeError) as error:
        raise ValueError(f"not an entry of this version: {error!r}") from error


def _storable(text: str) -> str:
    """Text that every database takes: no NUL, no half of a surrogate pair."""
    return text.replace("\0", "").encode(errors="replace").decode()
