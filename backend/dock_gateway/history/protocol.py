"""What the gateway asks of any place that keeps goals and events. docs/history.md says what is kept for how long."""

import hashlib
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Protocol

from dock_gateway.core.event import Event
from dock_gateway.core.filters import GoalFilter
from dock_gateway.core.goal import Goal, Json
from dock_gateway.history.battery import BatterySpan, Bucket

KEY_LIFETIME = timedelta(hours=24)
# The id of an event sorts before this.
NEVER = "~"


@dataclass(frozen=True)
class HistoryStats:
    """How the keeping goes.

    Attributes:
        waiting: Goals and events in memory that are not in the database yet.
        spooled: Entries of the spool that are not in the database yet.
        dropped: Feedback and battery events that were given up since the start, for want of memory.
        database_reachable: Whether the database took what it was given last.
        last_error: What it said when it did not; else what happened to what was kept before.
    """

    waiting: int = 0
    spooled: int = 0
    dropped: int = 0
    database_reachable: bool = True
    last_error: str | None = None


@dataclass(frozen=True)
class Incident:
    """What was kept is kept no more, since when, and what to do about it."""

    since: datetime
    detail: str


@dataclass(frozen=True)
class Acknowledgement:
    """Who has acknowledged an alert, and when."""

    by: str
    at: datetime


@dataclass(frozen=True)
class LaterEvents:
    """The events that follow one, in the order of their ids; `complete` where none of them was given up."""

    events: list[Event]
    complete: bool


class AcknowledgementStore(Protocol):
    """Keeps who has acknowledged which alert."""

    async def read(self) -> dict[str, Acknowledgement]:
        """All of them, by the id of the alert.

        Raises:
            Unavailable: The database does not answer (`history_unavailable`).
        """

    async def write(self, alert_id: str, acknowledgement: Acknowledgement | None) -> None:
        """Keep one in place of what there was, or none.

        Raises:
            Unavailable: The database does not answer (`history_unavailable`).
        """


class History(Protocol):
    """Keeps goals, their events and the idempotency keys they were sent with. Goals are handed out as copies.

    What reads from the database raises `Unavailable` (`history_unavailable`) when that does not answer in time and what
    is asked for is not in memory either; nothing is ever said to be missing merely because it cannot be looked up.
    """

    @property
    def acknowledgements(self) -> AcknowledgementStore:
        """Who has acknowledged which alert."""

    @property
    def incident(self) -> Incident | None:
        """What happened to what was kept, as long as somebody has to know of that."""

    on_loss: Callable[[], None]
    """Called when what was kept is lost, for goals that have not ended to be recorded again."""

    async def add(self, goal: Goal, idempotency_key: str | None = None) -> None:
        """Keep a new goal; it is safe once this returns: committed, or on this machine's disk.

        Raises:
            Unavailable: Neither the database nor the disk took it (`history_unavailable`).
        """

    async def claim(self, idempotency_key: str, goal_id: str, fingerprint: str) -> tuple[str, str]:
        """Bind a key to a goal for 24 hours; returns goal_id and fingerprint of whoever was first, across replicas."""

    async def release(self, idempotency_key: str, goal_id: str) -> None:
        """Let go of a key whose goal was never sent; the key of another goal stays bound.

        Raises:
            Unavailable: The database does not answer (`history_unavailable`), so the key stays bound.
        """

    def record(self, goal: Goal) -> None:
        """Take note of a goal of someone else, or of a change, as it stands now; never waits, never raises."""

    def record_event(self, event: Event) -> None:
        """Take note of an event, once however often it is recorded; never waits, never raises.

        One without an id is not kept.
        """

    async def seal(self, goal: Goal, end: Sequence[Event]) -> list[Event]:
        """Store how a goal ended before anyone is told: a process that is killed then neither repeats nor forgets it.

        Waits a tenth of a second at most, and never raises.

        Returns:
            The events of the end as they are stored: those of another gateway, where that was first.
        """

    @property
    def shared(self) -> bool:
        """Whether other gateways may keep the same goals there."""

    @property
    def newest(self) -> str:
        """Id of the newest event that was stored when the history was opened; empty where there was none."""

    async def page(self, wanted: GoalFilter, *, limit: int, before: str | None = None) -> list[Goal]:
        """Goals, newest first, those older than the goal `before` where it is given."""

    async def get(self, goal_id: str) -> Goal | None:
        """One goal."""

    async def known(self, goal_ids: Collection[str]) -> dict[str, Goal]:
        """Those of these goals that are known, by id."""

    async def by_key(self, idempotency_key: str) -> Goal | None:
        """The goal that was sent with this key, within the last 24 hours."""

    async def unfinished(self, *, complete: bool = False) -> list[Goal]:
        """The goals whose status is not final, oldest first, to be taken up after a restart.

        While the database is away these are only the ones that are in the spool.

        Args:
            complete: Rather none than only those.

        Raises:
            Unavailable: They are to be complete, and the database does not answer (`history_unavailable`).
        """

    async def events_after(
        self, event_id: str, *, goal_id: str | None, action_name: str | None, topics: frozenset[str], limit: int
    ) -> LaterEvents:
        """The events that follow one, whether that one is stored or not."""

    async def events_of(
        self, goal_id: str, *, kinds: Collection[str], after: str = "", until: str = NEVER, limit: int
    ) -> list[Event]:
        """The events of a goal after one and up to another, oldest first; `kinds` as in `events.KINDS`."""

    async def knows_all_of(self, goal: Goal) -> bool:
        """Whether no event of a goal has been given up."""

    async def battery(self, span: BatterySpan) -> list[Bucket]:
        """The battery states of a span in buckets, oldest first; those without any are left out."""

    def stats(self) -> HistoryStats:
        """How the keeping goes."""

    async def close(self) -> None:
        """Write what waits, for a second at most; the rest is spooled."""


def fingerprint_of(action_name: str, goal: Json | None) -> str:
    """What tells whether two goals that were sent with the same key are the same goal."""
    return hashlib.sha256(action_name.encode() + b"\0" + (goal or b"")).hexdigest()


def selects(event: Event, goal_id: str | None, action_name: str | None, topics: frozenset[str]) -> bool:
    """Whether an event is one of those that `events_after` was asked for."""
    if event.topic != "goals" or event.topic not in topics:
        return event.topic in topics
    return goal_id in (None, event.goal_id) and action_name in (None, event.action_name)
