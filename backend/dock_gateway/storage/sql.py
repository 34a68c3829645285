"""The history in a database, or in one in memory. Reads include the entries that are not written yet."""

import asyncio
import logging
import time
from collections.abc import Awaitable, Callable, Collection, Sequence
from contextlib import suppress
from copy import copy
from datetime import UTC, datetime
from functools import partial
from pathlib import Path

from dock_gateway.core.errors import Unavailable
from dock_gateway.core.event import Event, time_id
from dock_gateway.core.filters import GoalFilter
from dock_gateway.core.goal import Goal
from dock_gateway.core.tasks import cancel
from dock_gateway.storage import queries, statistics
from dock_gateway.storage.audit import SqlAudit
from dock_gateway.storage.battery import BatterySpan, Bucket
from dock_gateway.storage.database import DATABASE_ERRORS, Database, Incident
from dock_gateway.storage.entries import SqlEntries
from dock_gateway.storage.event_reader import EventReader
from dock_gateway.storage.immediate import ImmediateWriter
from dock_gateway.storage.merge import merge_all
from dock_gateway.storage.notes import SqlNotes
from dock_gateway.storage.protocol import (
    KEY_LIFETIME,
    NEVER,
    EntryT,
    HistoryStats,
    LaterEvents,
    fingerprint_of,
)
from dock_gateway.storage.reader import AWAY, Reader
from dock_gateway.storage.retention import Limits, Retention
from dock_gateway.storage.rows import Key
from dock_gateway.storage.seals import Sealer
from dock_gateway.storage.spool import Spool
from dock_gateway.storage.statistics import Span, Tallies
from dock_gateway.storage.waiting import Waiting
from dock_gateway.storage.writer import Writer

log = logging.getLogger(__name__)

OPEN_TIMEOUT = 2.0  # Seconds that the start waits for the database.
CLOSE_TIMEOUT = 1.0  # Seconds.
LOOK_INTERVAL = 2.0  # Seconds between two polls of the database.
KEPT_TOPICS = ("goals", "battery", "cmd_vel")
KEY_TIMEOUT = 0.5  # Seconds to look up an idempotency key before its goal is sent.
MAX_KEYS = 10_000


class SqlHistory:
    """Goals, events and keys in SQLite or PostgreSQL, with a spool as fallback.

    Args:
        url: `sqlite:///path`, `postgresql://…` or `memory:`.
        spool: Takes entries while the database does not answer.
        max_waiting: The maximum number of events, and of goals, that wait in memory.
        limits: How much is kept, and for how long.

    Attributes:
        database: Runs transactions, each on a thread.
        writer: Writes what waits in memory.
        reader: Reads from the database.
        immediate: Writes what a request waits for.
    """

    def __init__(self, url: str, spool: Spool, *, max_waiting: int, limits: Limits) -> None:
        self.database = open_database(url)
        self._spool = spool
        self._waiting = Waiting(max_waiting)
        self.writer = Writer(self.database, self._spool, self._waiting, self._write_again)
        self._sealer = Sealer(self.database)
        self._keys: dict[str, Key] = {}
        self._newest = ""
        self.shared = self.database.shared
        self.reader = Reader(self.database, self.writer)
        self.immediate = ImmediateWriter(self.database, self.writer)
        self.notes = SqlNotes(self.reader, self.immediate)
        self.audit = SqlAudit(self.reader, self.immediate)
        self._events = EventReader(self.reader, self._waiting)
        self.retention = Retention(self.database, limits)
        self.on_loss: Callable[[], None] = lambda: None
        self._tasks: list[asyncio.Task[None]] = []

    async def open(self) -> None:
        """Load what an earlier process left in the spool, and wait up to two seconds for the database."""
        await self.writer.take_over()
        self.writer.start()
        with suppress(TimeoutError):
            async with asyncio.timeout(OPEN_TIMEOUT):
                await self.writer.answered.wait()
        work = (self._sealer.run(), self.retention.run(), self._look_after_database())
        self._tasks = [asyncio.create_task(each) for each in work]
        await self._sealer.open()  # first: what is stored later comes with a turn, and all else has to be in `_newest`
        with suppress(Unavailable):
            self._keys = {key.key: key for key in await self.reader.read(queries.newest_keys, MAX_KEYS)}
            self._newest = await self.reader.read(queries.newest)
        for key in self._waiting.keys.values():
            self._keys.setdefault(key.key, key)

    async def _look_after_database(self) -> None:
        """Poll the database, so that an outage or a replaced file is noticed without any writes."""
        while True:
            await asyncio.sleep(LOOK_INTERVAL)
            with suppress(Unavailable):
                await self.reader.read(lambda _: None)
            self._sealer.ask()

    def _write_again(self) -> None:
        """After the database lost its data: queue what this process knows, and mark the rest as missing."""
        now = time_id(time.time_ns())
        self._waiting.gaps |= dict.fromkeys(KEPT_TOPICS, now)
        for key in self._keys.values():
            self._waiting.put_key(key)
        self.on_loss()

    @property
    def newest(self) -> str:
        """The id of the newest event stored when the history was opened, or that a turn returned before `follow`."""
        return max(self._newest, self._sealer.newest)

    @property
    def incident(self) -> Incident | None:
        """The last loss of the database's data, as long as it must be reported."""
        return self.database.incident

    def documents(self, kind: str, model: type[EntryT]) -> SqlEntries[EntryT]:
        """Return the entries of a kind."""
        return SqlEntries(self.reader, self.immediate, kind, model)

    # ------------------------------------------------------------------ write

    async def add(self, goal: Goal, idempotency_key: str | None = None) -> None:
        """Store a new goal; on return it is in the database or in the spool."""
        key = None
        if idempotency_key is not None:
            key = self._held(idempotency_key)
            if key is None:
                key = _new_key(idempotency_key, goal.goal_id, fingerprint_of(goal.action_name, goal.goal))
                self._hold(key)
        await self.writer.keep(goal, key)

    async def claim(self, idempotency_key: str, goal_id: str, fingerprint: str) -> tuple[str, str]:
        """Bind a key to a goal, or return its owner.

        While the database does not answer, the key is bound in this process and its successors, not at other replicas.
        """
        held = self._held(idempotency_key)
        if held is None:
            held = _new_key(idempotency_key, goal_id, fingerprint)
            if self.writer.reachable:
                try:
                    async with asyncio.timeout(KEY_TIMEOUT):
                        # Not durable: the goal, which is written next, is, and so is what was written before it.
                        held = await self.database.write(queries.claim, held, durable=False)
                except DATABASE_ERRORS as error:
                    self.writer.doubt(error)
            held = self._held(idempotency_key) or held
            self._hold(held)
        return held.goal_id, held.fingerprint

    async def release(self, idempotency_key: str, goal_id: str) -> None:
        """Release the key of a goal, here and at all replicas.

        A replica that has held the key since the first attempt retries with the same goal, and finds another's key.
        """
        if not self.writer.reachable:
            raise Unavailable(AWAY, code="history_unavailable")
        try:
            async with asyncio.timeout(KEY_TIMEOUT):
                await self.database.write(queries.release, idempotency_key, goal_id)
        except DATABASE_ERRORS as error:
            self.writer.doubt(error)
            raise Unavailable(AWAY, code="history_unavailable") from error
        held = self._keys.get(idempotency_key)
        if held is not None and held.goal_id == goal_id:
            del self._keys[idempotency_key]
        self._waiting.forget_key(idempotency_key, goal_id)

    def _held(self, key: str) -> Key | None:
        held = self._keys.get(key)
        return None if held is None or held.expired else held

    def _hold(self, key: Key) -> None:
        self._keys.pop(key.key, None)
        self._keys[key.key] = key
        if len(self._keys) > MAX_KEYS:
            del self._keys[next(iter(self._keys))]

    def record(self, goal: Goal) -> None:
        """Record the current state of a goal."""
        self._waiting.put_goal(goal)
        self.writer.notice()

    def record_event(self, event: Event) -> None:
        """Record an event; duplicates are ignored."""
        if event.id is not None:
            self._waiting.put_event(event)
            self.writer.notice()

    def seal(self, goal: Goal, events: Sequence[Event]) -> Awaitable[list[Event] | None]:
        """Record a goal, then store it and its events now, if the database answers; return them as stored."""
        self.record(goal)
        if events and not self.database.volatile:
            self._waiting.hold(goal.goal_id)
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
                self._waiting.let_go(goal.goal_id)
                self.writer.notice()

    def follow(self, publish: Callable[[list[Event], str | None], None]) -> Callable[[], None]:
        """Publish in the order of all gateways that share the database; return what asks for more."""
        return self._sealer.follow(publish)

    # ------------------------------------------------------------------ read

    async def page(self, wanted: GoalFilter, *, limit: int, before: str | None = None) -> list[Goal]:
        """Return goals, newest first."""
        self.reader.require_everything()
        read = partial(queries.page_with_waiting, limit=limit, before=before)
        return await self.reader.read(read, wanted, dict(self._waiting.goals))

    async def action_names(self) -> set[str]:
        """Return the names of the actions that have goals."""
        self.reader.require_everything()
        waiting = {goal.action_name for goal in self._waiting.goals.values()}
        return waiting | await self.reader.read(queries.action_names)

    async def get(self, goal_id: str) -> Goal | None:
        """Return a goal, or None if there is no such goal."""
        waiting = self._waiting.goals.get(goal_id)
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
        """Return the stored goals among these ids, by id."""
        waiting = {goal_id: self._waiting.goals[goal_id] for goal_id in goal_ids if goal_id in self._waiting.goals}
        stored = await self.reader.read(queries.goals_by_id, list(goal_ids))
        found = {**stored, **merge_all(stored, waiting)}
        if len(found) < len(goal_ids):
            self.reader.require_everything()
        return found

    async def by_key(self, idempotency_key: str) -> Goal | None:
        """Return the goal sent with this key."""
        key = self._held(idempotency_key)
        if key is None:
            key = await self.reader.read(queries.key_of, idempotency_key, timeout=KEY_TIMEOUT)
        return None if key is None else await self.get(key.goal_id)

    async def unfinished(self, *, complete: bool = False) -> list[Goal]:
        """Return the goals without a final status, oldest first."""
        if complete:
            self.reader.require_everything()
        waiting = dict(self._waiting.goals)
        stored: dict[str, Goal] = {}
        try:
            stored = await self.reader.read(queries.unfinished_or, list(waiting))
        except Unavailable:
            if complete:
                raise
        goals = {**stored, **merge_all(stored, waiting)}.values()
        return sorted((goal for goal in goals if not goal.status.final), key=queries.position)

    async def events_after(
        self, event_id: str, *, goal_id: str | None, action_name: str | None, topics: frozenset[str], limit: int
    ) -> LaterEvents:
        """Return the events after a given id, oldest first."""
        return await self._events.after(event_id, goal_id=goal_id, action_name=action_name, topics=topics, limit=limit)

    async def events_of(
        self, goal_id: str, *, kinds: Collection[str], after: str = "", until: str = NEVER, limit: int
    ) -> list[Event]:
        """Return the events of a goal between two ids, oldest first."""
        return await self._events.of_goal(goal_id, kinds=kinds, after=after, until=until, limit=limit)

    async def knows_all_of(self, goal: Goal) -> bool:
        """Return whether no event of a goal is missing."""
        return await self._events.knows_all_of(goal)

    async def battery(self, span: BatterySpan) -> list[Bucket]:
        """Return the battery states of a span in buckets, oldest first."""
        return await self._events.battery(span)

    async def tally(self, wanted: GoalFilter, spans: Sequence[Span], *, by_action: bool) -> list[Tallies]:
        """Return how the wanted goals ended, for each span of the time when they were created."""
        self.reader.require_everything()
        rows = await self.reader.read_much(statistics.read_rows, wanted, spans, by_action)
        return await asyncio.to_thread(statistics.tally_rows, rows)

    # ------------------------------------------------------------------ the rest

    def stats(self) -> HistoryStats:
        """Return the state of the history."""
        incident, writer = self.incident, self.writer
        reasons = (writer.last_error or (incident.detail if incident else None), writer.awaited)
        return HistoryStats(
            waiting=len(self._waiting),
            spooled=self._spool.count,
            dropped=self._waiting.dropped,
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


def _new_key(key: str, goal_id: str, fingerprint: str) -> Key:
    return Key(key, goal_id, fingerprint, datetime.now(UTC) + KEY_LIFETIME)
