"""Conversion of goals, events and keys to table rows and spool lines, and back."""

import hashlib
import zlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta
from typing import Any

import orjson

from dock_gateway.core.audit import AuditEntry
from dock_gateway.core.event import Event
from dock_gateway.core.goal import Goal, GoalError, GoalStatus, Json

Row = dict[str, Any]

# The maximum number of goals and of events per transaction.
BATCH_GOALS = 200
BATCH_EVENTS = 1000
# Characters of an error code. Action servers may send any text, and the database limits the size of an index entry.
MAX_CODE = 200

_TIMES = ("created_at", "updated_at", "finished_at")
_MESSAGES = ("goal", "feedback", "result")


KEY_LIFETIME = timedelta(hours=24)


@dataclass(frozen=True)
class Key:
    """An idempotency key and its goal."""

    key: str
    goal_id: str
    fingerprint: str
    expires_at: datetime

    @property
    def expired(self) -> bool:
        """Whether another goal may use the key."""
        return self.expires_at <= datetime.now(UTC)


def fingerprint_of(action_name: str, goal: Json | None) -> str:
    """Return a hash that tells whether two goals sent with the same key are the same goal."""
    return hashlib.sha256(action_name.encode() + b"\0" + (goal or b"")).hexdigest()


Entry = Goal | Event | Key


@dataclass
class Batch:
    """The entries of one transaction. `gaps` maps topics to the id of their newest dropped event."""

    goals: list[Goal] = field(default_factory=list)
    events: list[Event] = field(default_factory=list)
    keys: list[Key] = field(default_factory=list)
    gaps: dict[str, str] = field(default_factory=dict)

    @classmethod
    def joined(cls, batches: "Iterable[Batch]") -> "Batch":
        """Return the goals, in their last version, the events and the keys of several batches."""
        batches = list(batches)
        return cls(
            goals=list({goal.goal_id: goal for batch in batches for goal in batch.goals}.values()),
            events=[event for batch in batches for event in batch.events],
            keys=[key for batch in batches for key in batch.keys],
        )

    def __len__(self) -> int:
        return len(self.goals) + len(self.events) + len(self.keys) + len(self.gaps)

    @property
    def full(self) -> bool:
        """Whether a limit was reached, so that more entries may be pending."""
        return len(self.goals) >= BATCH_GOALS or len(self.keys) >= BATCH_GOALS or len(self.events) >= BATCH_EVENTS

    @property
    def must_keep(self) -> bool:
        """Whether any entry must survive a power cut."""
        return bool(self.goals or self.keys or any(not event.droppable for event in self.events))

    def split(self) -> "list[Batch]":
        """Return a batch for each entry, to find the one that the database refuses."""
        return [
            *(Batch(goals=[goal]) for goal in self.goals),
            *(Batch(events=[event]) for event in self.events),
            *(Batch(keys=[key]) for key in self.keys),
            *(Batch(gaps={topic: event_id}) for topic, event_id in self.gaps.items()),
        ]


def goal_row(goal: Goal) -> Row:
    """Convert a goal to a table row."""
    error = goal.error
    return {
        "goal_id": goal.goal_id,
        "action_name": goal.action_name,
        "action_type": goal.action_type,
        "verb": goal.verb,
        "origin": goal.origin,
        "status": goal.status.value,
        "stalled": goal.stalled,
        "goal": goal.goal,
        "feedback": goal.feedback,
        "result": goal.result,
        "error_code": error and _storable(error.code)[:MAX_CODE],
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
    """Convert a table row to a goal."""
    goal = Goal(
        goal_id=row["goal_id"],
        action_name=row["action_name"],
        action_type=row["action_type"],
        created_at=row["created_at"],
        origin=row["origin"],
        verb=row["verb"] or None,
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
    """Convert an event to a table row."""
    return {
        "id": event.id,
        "topic": event.topic,
        "goal_id": event.goal_id,
        "action_name": event.action_name,
        "robot": event.robot,
        # A stop must not be lost on the way, but belongs to no goal that it could be deleted with.
        "droppable": event.droppable or event.goal_id is None,
        "size": len(event.data),
        "data": event.data,
        "key": event.key,
    }


def event_of(row: Mapping[Any, Any]) -> Event:
    """Convert a table row to an event."""
    return Event(
        row["data"],
        row["topic"],
        row["goal_id"],
        row["action_name"],
        row["droppable"],
        id=row["id"],
        robot=row["robot"],
        key=row["key"],
    )


def key_row(key: Key) -> Row:
    """Convert a key to a table row."""
    return {"key": key.key, "goal_id": key.goal_id, "fingerprint": key.fingerprint, "expires_at": key.expires_at}


def line_of(entry: Entry) -> bytes:
    """Convert an entry to a spool line: a checksum, then JSON."""
    kind, row = (
        ("goal", goal_row(entry))
        if isinstance(entry, Goal)
        else ("event", event_row(entry))
        if isinstance(entry, Event)
        else ("key", key_row(entry))
    )
    texts = {name: value.decode() if isinstance(value, bytes) else value for name, value in row.items()}
    return _checked_line({kind: texts})


def audit_line_of(entry: AuditEntry) -> bytes:
    """Convert an entry of the audit log to a spool line."""
    return _checked_line(vars(entry))


def _checked_line(document: dict[str, Any]) -> bytes:
    body = orjson.dumps(document)
    return b"%08x %s\n" % (zlib.crc32(body), body)


def entry_of(line: bytes) -> Entry:
    """Convert a spool line to its entry.

    Raises:
        ValueError: The line is damaged.
    """
    ((kind, row),) = _read_checked(line).items()
    try:
        if kind == "goal":
            times = {name: row[name] and datetime.fromisoformat(row[name]) for name in _TIMES}
            messages = {name: row[name] if row[name] is None else row[name].encode() for name in _MESSAGES}
            return goal_of(row | times | messages)
        if kind == "event":
            return event_of(row | {"data": row["data"].encode()})
        return Key(**row | {"expires_at": datetime.fromisoformat(row["expires_at"])})
    except (KeyError, TypeError, AttributeError) as error:
        raise ValueError(f"not an entry of this version: {error!r}") from error


def audit_entry_of(line: bytes) -> AuditEntry:
    """Convert a spool line to its entry of the audit log.

    Raises:
        ValueError: The line is damaged.
    """
    fields = _read_checked(line)
    try:
        return AuditEntry(**fields | {"acted_at": datetime.fromisoformat(fields["acted_at"])})
    except (KeyError, TypeError) as error:
        raise ValueError(f"not an entry of this version: {error!r}") from error


def _read_checked(line: bytes) -> dict[str, Any]:
    checksum, _, body = line.rstrip(b"\n").partition(b" ")
    if int(checksum, 16) != zlib.crc32(body):
        raise ValueError("the checksum is wrong")
    document: dict[str, Any] = orjson.loads(body)
    return document


def _storable(text: str) -> str:
    """Remove what databases do not accept in text: NULs and lone surrogates."""
    return text.replace("\0", "").encode(errors="replace").decode()
