"""The history in a database, or in one in memory. Reads include the entries that are not written yet."""

import asyncio
import logging
import time
from collections.abc import Awaitable, Callable, Collection, Sequence
from contextlib import suppress
from copy import copy
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from dock_gateway.core.cursor import Cursor
from dock_gateway.core.errors import Unavailable
from dock_gateway.core.event import NEVER, Event, time_id
from dock_gateway.core.filters import GoalFilter
from dock_gateway.core.goal import Goal
from dock_gateway.core.listeners import Listeners
from dock_gateway.core.tasks import cancel
from dock_gateway.storage import queries
from dock_gateway.storage.audit import AuditStore
from dock_gateway.storage.battery import BatterySpan, Bucket
from dock_gateway.storage.database import DATABASE_ERRORS, Database, Incident
from dock_gateway.storage.entries import Entries, EntryT
from dock_gateway.storage.event_reader import EventReader, LaterEvents
from dock_gateway.storage.immediate import ImmediateWriter
from dock_gateway.storage.keys import IdempotencyKeys
from dock_gateway.storage.merge import merge_all
from dock_gateway.storage.notes import Notes
from dock_gateway.storage.reader import Reader
from dock_gateway.storage.retention import Limits, Retention
from dock_gateway.storage.sealer import Sealer
from dock_gateway.storage.spool import Spool
from dock_gateway.storage.waiting import WaitingEntries
from dock_gateway.storage.writer import Writer

log = logging.getLogger(__name__)

OPEN_TIMEOUT = 2.0  # Seconds that the start waits for the database.
CLOSE_TIMEOUT = 1.0  # Seconds.
POLL_INTERVAL = 2.0  # Seconds between two polls of the database.
KEPT_TOPICS = ("goals", "battery", "cmd_vel")


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


class History:
    """Goals, their events and their idempotency keys in SQLite or PostgreSQL, with a spool as fallback.

    Goals are returned as copies. A read raises `Unavailable` (`history_unavailable`) if the database does not answer in
    time and the data is not in memory either. A failed lookup is never reported as missing data. docs/history.md lists
    what is kept and for how long.

    Args:
        url: `sqlite:///path`, `postgresql://…` or `memory:`.
        spool: Takes entries while the database does not answer.
        max_waiting: The maximum number of events, and of goals, that wait in memory.
        limits: How much is kept, and for how long.

    Attributes:
        database: Runs transactions, each on a thread.
        spool: As given.
        waiting: What is not in the database yet.
        writer: Writes what waits in memory.
        reader: Reads from the database.
        immediate: Writes what a request waits for.
        notes: The notes and tags of goals.
        audit: The audit log.
        shared: Whether other gateways may store goals in the same database.
        on_loss: Called when stored data is lost, so that unfinished goals are recorded again.
    """

    def __init__(self, url: str, spool: Spool, *, max_waiting: int, limits: Limits) -> None:
        self.database = open_database(url)
        self.spool = spool
        self.waiting = WaitingEntries(max_waiting)
        self.writer = Writer(self.database, self.spool, self.waiting, self._write_again)
        self._sealer = Sealer(self.database)
        self._newest = ""
        self.shared = self.database.shared
        self.reader = Reader(self.database, self.writer)
        self.immediate = ImmediateWriter(self.database, self.writer)
        self._keys = IdempotencyKeys(self.database, self.writer, self.reader, self.waiting)
        self.notes = Notes(self.reader, self.immediate)
        self.audit = AuditStore(self.reader, self.immediate)
        self._events = EventReader(self.reader, self.waiting)
        self.retention = Retention(self.database, limits)
        self.on_loss = Listeners[[]]("stored data was lost")
        self._tasks: list[asyncio.Task[None]] = []

    async def open(self) -> None:
        """Load what an earlier process left in the spool, and wait up to two seconds for the database."""
        await self.writer.take_over()
        self.writer.start()
        with suppress(TimeoutError):
            async with asyncio.timeout(OPEN_TIMEOUT):
                await self.writer.answered.wait()
        work = (self._sealer.run(), self.retention.run(), self._poll_database())
        self._tasks = [asyncio.create_task(each) for each in work]
        await self._sealer.open()  # first: what is stored later comes with a turn, and all else has to be in `_newest`
        with suppress(Unavailable):
            self._newest = await self.reader.read(queries.newest)
        await self._keys.load()

    async def _poll_database(self) -> None:
        """Poll the database, so that an outage or a replaced file is noticed without any writes."""
        while True:
            await asyncio.sleep(POLL_INTERVAL)
            with suppress(Unavailable):
                await self.reader.read(lambda _: None)
            self._sealer.ask()

    def _write_again(self) -> None:
        """After the database lost its data: queue what this process knows, and mark the rest as missing."""
        now = time_id(time.time_ns())
        self.waiting.gaps |= dict.fromkeys(KEPT_TOPICS, now)
        self._keys.store_again()
        self.on_loss()

    @property
    def newest(self) -> str:
        """The id of the newest event that is stored, but not published here after `follow`; empty if there is none."""
        return max(self._newest, self._sealer.newest)

    @property
    def incident(self) -> Incident | None:
        """The last loss of stored data, as long as it must be reported."""
        return self.database.incident

    def documents(self, kind: str, model: type[EntryT]) -> Entries[EntryT]:
        """Return the entries of a kind. They are stored as JSON, so that a new field changes no table.

        A field that a document lacks has its default; one that the model does not know is ignored.

        Args:
            kind: The kind: `rule`, `webhook`, `user`, ….
            model: The dataclass or pydantic model of an entry.
        """
        return Entries(self.reader, self.immediate, kind, model)

    # ------------------------------------------------------------------ write

    async def add(self, goal: Goal, idempotency_key: str | None = None) -> None:
        """Store a new goal. On return it is committed to the database or on this machine's disk.

        Raises:
            Unavailable: Neither the database nor the disk took it (`history_unavailable`).
        """
        await self.writer.keep(goal, None if idempotency_key is None else self._keys.of(goal, idempotency_key))

    async def claim(self, idempotency_key: str, goal_id: str, fingerprint: str) -> tuple[str, str]:
        """Bind a key to a goal for 24 hours; return goal_id and fingerprint of the first claim, across replicas.

        While the database does not answer, the key is bound in this process and its successors, not at other replicas.
        """
        return await self._keys.claim(idempotency_key, goal_id, fingerprint)

    async def release(self, idempotency_key: str, goal_id: str) -> None:
        """Release a key whose goal was never sent, here and at all replicas; a key of another goal stays bound.

        A replica that has held the key since the first attempt retries with the same goal, and finds another's key.

        Raises:
            Unavailable: The database does not answer (`history_unavailable`), so the key stays bound.
        """
        await self._keys.release(idempotency_key, goal_id)

    def record(self, goal: Goal) -> None:
        """Record the current state of a goal, new or changed; never waits, never raises."""
        self.waiting.put_goal(goal)
        self.writer.notice()

    def record_event(self, event: Event) -> None:
        """Record an event; duplicates are ignored. Never waits, never raises.

        An event without an id is not stored.
        """
        if event.id is not None:
            self.waiting.put_event(event)
            self.writer.notice()

    def seal(self, goal: Goal, events: Sequence[Event]) -> Awaitable[list[Event] | None]:
        """Store events of a goal before they are published, so that a killed process neither repeats nor forgets them.

        Records the goal at once. What it returns waits a second at most, and never raises.

        Returns:
            The events as stored: those of another gateway, if it stored them first. In a history that is shared, a
            state that another gateway has made outdated is left out. None if they are not stored.
        """
        self.record(goal)
        if events and not self.database.volatile:
            self.waiting.hold(goal.goal_id)
        return self._seal(copy(goal), events)

    async def _seal(self, goal: Goal, events: Sequence[Event]) -> list[Event] | None:
        if self.database.volatile:
            return list(events)
        try:
            if not (self.writer.reachable and not self._sealer.slow if events else self.writer.answers):
                return None
            return await self._sealer.seal(goal, events)
        finally:
            if events:  # else some may be on the way already
                self.waiting.let_go(goal.goal_id)
                self.writer.notice()

    def follow(self, publish: Callable[[list[Event], str | None], None]) -> Callable[[], None]:
        """Publish in the order of all gateways that share the history.

        Args:
            publish: Called with the states and results of goals that any of them has stored, and the id up to which
                other events may be published then; None: all, as the database does not answer. Never called if none
                shares it.

        Returns:
            Asks for `publish` to be called again soon.
        """
        return self._sealer.follow(publish)

    # ------------------------------------------------------------------ read

    async def page(self, wanted: GoalFilter, *, limit: int, before: Cursor | None = None) -> list[Goal]:
        """Return goals, newest first; with `before`, only goals behind that cursor."""
        self.reader.require_everything()
        read = partial(queries.page_with_waiting, limit=limit, before=before)
        return await self.reader.read(read, wanted, dict(self.waiting.goals))

    async def action_names(self) -> set[str]:
        """Return the names of the actions that have goals."""
        self.reader.require_everything()
        waiting = {goal.action_name for goal in self.waiting.goals.values()}
        return waiting | await self.reader.read(queries.action_names)

    async def get(self, goal_id: str) -> Goal | None:
        """Return a goal, or None if there is no such goal."""
        waiting = self.waiting.goals.get(goal_id)
        waiting_now = {} if waiting is None else {goal_id: waiting}
        try:
            stored = await self.reader.read(queries.goals_by_id, [goal_id])
        except Unavailable:
            if waiting is None:
                raise
            return merge_all({}, waiting_now)[goal_id]
        goal = {**stored, **merge_all(stored, waiting_now)}.get(goal_id)
        if goal is None:
            self.reader.require_everything()
        return goal

    async def known(self, goal_ids: Collection[str]) -> dict[str, Goal]:
        """Return the stored goals among these ids, by id, to go on with those that have not ended."""
        waiting = {goal_id: self.waiting.goals[goal_id] for goal_id in goal_ids if goal_id in self.waiting.goals}
        stored = await self.reader.read(queries.goals_to_follow, list(goal_ids))
        found = {**stored, **merge_all(stored, waiting)}
        if len(found) < len(goal_ids):
            self.reader.require_everything()
        return found

    async def by_key(self, idempotency_key: str) -> Goal | None:
        """Return the goal sent with this key within the last 24 hours."""
        key = await self._keys.find(idempotency_key)
        return None if key is None else await self.get(key.goal_id)

    async def unfinished(self, *, complete: bool = False) -> list[Goal]:
        """Return the goals without a final status, oldest first, to be resumed after a restart.

        While the database does not answer, only the goals in memory are returned.

        Args:
            complete: Raise instead of returning only the goals in memory.

        Raises:
            Unavailable: `complete` is set, and the database does not answer or does not have all goals of the spool
                (`history_unavailable`).
        """
        if complete:
            self.reader.require_everything()
        waiting = dict(self.waiting.goals)
        stored: dict[str, Goal] = {}
        try:
            stored = await self.reader.read(queries.unfinished_or, list(waiting))
        except Unavailable:
            if complete:
                raise
        goals = {**stored, **merge_all(stored, waiting)}.values()
        return sorted((goal for goal in goals if not goal.status.final), key=queries.cursor_of)

    async def events_after(
        self, event_id: str, *, goal_id: str | None, action_name: str | None, topics: frozenset[str], limit: int
    ) -> LaterEvents:
        """Return the events after a given id, which need not be stored itself."""
        return await self._events.after(event_id, goal_id=goal_id, action_name=action_name, topics=topics, limit=limit)

    async def events_of(
        self, goal_id: str, *, kinds: Collection[str], after: str = "", until: str = NEVER, limit: int
    ) -> list[Event]:
        """Return the events of a goal between two ids, oldest first."""
        return await self._events.of_goal(goal_id, kinds=kinds, after=after, until=until, limit=limit)

    async def knows_all_of(self, goal: Goal) -> bool:
        """Return whether no event of a goal has been dropped."""
        return await self._events.knows_all_of(goal)

    async def has_battery(self, robot: str) -> bool:
        """Return whether there is a battery state of a robot."""
        return await self._events.has_battery(robot)

    async def battery(self, span: BatterySpan) -> list[Bucket]:
        """Return the battery states of a span in buckets, oldest first; empty buckets are left out."""
        return await self._events.battery(span)

    # ------------------------------------------------------------------ the rest

    def stats(self) -> HistoryStats:
        """Return the state of the history."""
        incident, writer = self.incident, self.writer
        reasons = (writer.last_error or (incident.detail if incident else None), writer.awaited)
        return HistoryStats(
            waiting=len(self.waiting),
            spooled=self.spool.count,
            dropped=self.waiting.dropped,
            database_reachable=writer.answers,
            last_error="; ".join(filter(None, reasons)) or None,
        )

    async def close(self) -> None:
        """Write the pending entries for at most one second; spool the rest."""
        await cancel(*self._tasks)
        await self.writer.close(CLOSE_TIMEOUT)
        with suppress(*DATABASE_ERRORS):
            async with asyncio.timeout(CLOSE_TIMEOUT):
                await self.database.close()


def open_database(url: str) -> Database:
    """Return the database at `sqlite:///path` or `postgresql://…`, not connected yet, or a new one for `memory:`."""
    if url == "memory:":
        from dock_gateway.storage.memory import MemoryDatabase  # noqa: PLC0415 - only the driver that is used

        return MemoryDatabase()
    if url.startswith("sqlite:///"):
        from dock_gateway.storage.sqlite import SqliteDatabase  # noqa: PLC0415

        return SqliteDatabase(Path(url.removeprefix("sqlite:///")))
    from dock_gateway.storage.postgresql import PostgresqlDatabase  # noqa: PLC0415

    return PostgresqlDatabase(url)
