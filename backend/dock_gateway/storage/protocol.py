"""The interface of every store of goals and events. docs/history.md lists what is kept and for how long."""

import hashlib
from collections.abc import Awaitable, Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Any, NamedTuple, Protocol, TypeVar

from dock_gateway.core.audit import AuditEntry, AuditFilter, AuditRow
from dock_gateway.core.event import Event
from dock_gateway.core.filters import GoalFilter
from dock_gateway.core.goal import Goal, Json
from dock_gateway.storage.battery import BatterySpan, Bucket
from dock_gateway.storage.database import Incident
from dock_gateway.storage.statistics import Span, Tallies

EntryT = TypeVar("EntryT")

KEY_LIFETIME = timedelta(hours=24)
# Sorts after the id of every event.
NEVER = "~"


@dataclass(frozen=True)
class HistoryStats:
    """The state of the history.

    Attributes:
        waiting: Goals and events in memory that are not in the database yet.
        spooled: Entries of the spool that are not in the database yet.
        dropped: Feedback and battery events dropped since the start because memory was full.
        database_reachable: Whether the last access to the database succeeded.
        last_error: The database's last error, or the detail of the incident, and what it is busy with while it does not
            answer. Never None while it is not reachable.
    """

    waiting: int = 0
    spooled: int = 0
    dropped: int = 0
    database_reachable: bool = True
    last_error: str | None = None


@dataclass(frozen=True)
class Acknowledgement:
    """Who has acknowledged an alert, and when."""

    by: str
    at: datetime


@dataclass(frozen=True)
class RobotLabel:
    """The display name of a robot, and the groups that it is in."""

    display_name: str | None
    groups: tuple[str, ...]


@dataclass(frozen=True)
class Note:
    """A note on a goal."""

    note_id: str
    by: str
    at: datetime
    text: str


@dataclass(frozen=True)
class GoalNotes:
    """The tags of a goal, sorted, and its notes, oldest first."""

    tags: tuple[str, ...]
    notes: tuple[Note, ...]


@dataclass(frozen=True)
class LaterEvents:
    """The events after a given one, ordered by id; `complete` if none of them was dropped."""

    events: list[Event]
    complete: bool


class Dependency(NamedTuple):
    """Entries of another kind that a write depends on.

    Attributes:
        entries: Where they are stored.
        check: Is given all of them, and raises if the write must not happen.
    """

    entries: "Entries[Any]"
    check: Callable[[Mapping[str, Any]], None]


class Entries(Protocol[EntryT]):
    """Stores entries by key."""

    async def read(self) -> dict[str, EntryT]:
        """Return all entries by their keys.

        Raises:
            Unavailable: The database does not answer (`history_unavailable`).
        """

    async def write(
        self,
        key: str,
        entry: EntryT | None,
        check: Callable[[Mapping[str, EntryT]], None] | None = None,
        dependency: Dependency | None = None,
    ) -> None:
        """Store an entry, replacing the earlier one; None deletes it.

        Args:
            key: The key.
            entry: The entry.
            check: Is given all entries, and raises if this one must not be stored. No other gateway can write between
                the check and the write.
            dependency: Entries of the same history that are checked likewise.

        Raises:
            Unavailable: The database does not answer (`history_unavailable`).
        """


class Notes(Protocol):
    """Stores notes and tags of goals.

    Every method raises `Unavailable` (`history_unavailable`) if the database does not answer in time; nothing has
    changed then.
    """

    async def of(self, goal_id: str) -> GoalNotes:
        """Return the notes and tags of a goal."""

    async def tags_of(self, goal_ids: Collection[str]) -> dict[str, tuple[str, ...]]:
        """Return the tags of those of the goals that have any, sorted."""

    async def all_tags(self) -> list[str]:
        """Return the tags of all goals, sorted."""

    async def add(self, goal_id: str, note: Note) -> GoalNotes:
        """Store a note; return what the goal has then.

        Raises:
            Conflict: The goal has too many notes (`too_many_notes`).
        """

    async def remove(self, goal_id: str, note_id: str) -> GoalNotes:
        """Delete a note; return what the goal has then.

        Raises:
            NotFound: The goal has no such note (`note_not_found`).
        """

    async def replace_tags(self, goal_id: str, tags: Collection[str]) -> GoalNotes:
        """Store the tags of a goal; return what it has then."""


class AuditStore(Protocol):
    """Stores the entries of the audit log.

    Both methods raise `Unavailable` (`history_unavailable`) if the database does not answer in time.
    """

    async def append(self, entries: Sequence[AuditEntry], *, durable: bool = True) -> list[AuditRow]:
        """Store entries in their order; return the new rows. Entries that are stored already are left out.

        Entries that are not `durable` may be lost in a power cut. That costs less, and new goals wait less for it.
        """

    async def page(self, wanted: AuditFilter, *, limit: int, before: int | None = None) -> list[AuditRow]:
        """Return rows, newest first; with `before`, only rows before that number."""


class History(Protocol):
    """Stores goals, their events and their idempotency keys. Goals are returned as copies.

    A read raises `Unavailable` (`history_unavailable`) if the database does not answer in time and the data is not in
    memory either. A failed lookup is never reported as missing data.
    """

    @property
    def notes(self) -> Notes:
        """The notes and tags of goals."""

    def documents(self, kind: str, model: type[EntryT]) -> Entries[EntryT]:
        """Return the entries of a kind. They are stored as JSON, so that a new field changes no table.

        A field that a document lacks has its default; one that the model does not know is ignored.

        Args:
            kind: The kind: `rule`, `webhook`, `user`, ….
            model: The dataclass or pydantic model of an entry.
        """

    @property
    def audit(self) -> AuditStore:
        """The audit log."""

    @property
    def incident(self) -> Incident | None:
        """The last loss of stored data, as long as it must be reported."""

    on_loss: Callable[[], None]
    """Called when stored data is lost, so that unfinished goals are recorded again."""

    async def add(self, goal: Goal, idempotency_key: str | None = None) -> None:
        """Store a new goal. On return it is committed to the database or on this machine's disk.

        Raises:
            Unavailable: Neither the database nor the disk took it (`history_unavailable`).
        """

    async def claim(self, idempotency_key: str, goal_id: str, fingerprint: str) -> tuple[str, str]:
        """Bind a key to a goal for 24 hours; return goal_id and fingerprint of the first claim, across replicas."""

    async def release(self, idempotency_key: str, goal_id: str) -> None:
        """Release a key whose goal was never sent; a key of another goal stays bound.

        Raises:
            Unavailable: The database does not answer (`history_unavailable`), so the key stays bound.
        """

    def record(self, goal: Goal) -> None:
        """Record the current state of a goal, new or changed; never waits, never raises."""

    def record_event(self, event: Event) -> None:
        """Record an event; duplicates are ignored. Never waits, never raises.

        An event without an id is not stored.
        """

    def seal(self, goal: Goal, events: Sequence[Event]) -> Awaitable[list[Event] | None]:
        """Store events of a goal before they are published, so that a killed process neither repeats nor forgets them.

        Records the goal at once. What it returns waits a second at most, and never raises.

        Returns:
            The events as stored: those of another gateway, if it stored them first. In a history that is shared, a
            state that another gateway has made outdated is left out. None if they are not stored.
        """

    def follow(self, publish: Callable[[list[Event], str | None], None]) -> Callable[[], None]:
        """Publish in the order of all gateways that share the history.

        Args:
            publish: Called with the states and results of goals that any of them has stored, and the id up to which
                other events may be published then; None: all, as the database does not answer. Never called if none
                shares it.

        Returns:
            Asks for `publish` to be called again soon.
        """

    @property
    def shared(self) -> bool:
        """Whether other gateways may store goals in the same database."""

    @property
    def newest(self) -> str:
        """The id of the newest event that is stored, but not published here after `follow`; empty if there is none."""

    async def page(self, wanted: GoalFilter, *, limit: int, before: str | None = None) -> list[Goal]:
        """Return goals, newest first; with `before`, only goals older than that one."""

    async def action_names(self) -> set[str]:
        """Return the names of the actions that have goals."""

    async def get(self, goal_id: str) -> Goal | None:
        """Return a goal, or None if there is no such goal."""

    async def known(self, goal_ids: Collection[str]) -> dict[str, Goal]:
        """Return the stored goals among these ids, by id."""

    async def by_key(self, idempotency_key: str) -> Goal | None:
        """Return the goal sent with this key within the last 24 hours."""

    async def unfinished(self, *, complete: bool = False) -> list[Goal]:
        """Return the goals without a final status, oldest first, to be resumed after a restart.

        While the database does not answer, only the goals in memory are returned.

        Args:
            complete: Raise instead of returning only the goals in memory.

        Raises:
            Unavailable: `complete` is set, and the database does not answer or does not have all goals of the spool
                (`history_unavailable`).
        """

    async def events_after(
        self, event_id: str, *, goal_id: str | None, action_name: str | None, topics: frozenset[str], limit: int
    ) -> LaterEvents:
        """Return the events after a given id, which need not be stored itself."""

    async def events_of(
        self, goal_id: str, *, kinds: Collection[str], after: str = "", until: str = NEVER, limit: int
    ) -> list[Event]:
        """Return the events of a goal from `after` (exclusive) to `until` (inclusive), oldest first.

        `kinds` as in `events.KINDS`.
        """

    async def knows_all_of(self, goal: Goal) -> bool:
        """Return whether no event of a goal has been dropped."""

    async def battery(self, span: BatterySpan) -> list[Bucket]:
        """Return the battery states of a span in buckets, oldest first; empty buckets are left out."""

    async def tally(self, wanted: GoalFilter, spans: Sequence[Span], *, by_action: bool) -> list[Tallies]:
        """Return how the wanted goals ended, for each span of the time when they were created.

        Goals that are not in the database yet are not counted: an ended goal is written before its end is published, or
        half a second after it.
        """

    def stats(self) -> HistoryStats:
        """Return the state of the history."""

    async def close(self) -> None:
        """Write the pending entries for at most one second; spool the rest."""


def fingerprint_of(action_name: str, goal: Json | None) -> str:
    """Return a hash that tells whether two goals sent with the same key are the same goal."""
    return hashlib.sha256(action_name.encode() + b"\0" + (goal or b"")).hexdigest()
