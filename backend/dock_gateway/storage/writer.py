"""Write-behind in batches: retries when the database fails, and spools what must be kept."""

import asyncio
import logging
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

import sqlalchemy.exc as sa_errors

from dock_gateway.core.errors import Unavailable
from dock_gateway.core.goal import Goal
from dock_gateway.storage import queries
from dock_gateway.storage.database import DATABASE_ERRORS, WRITE_TIMEOUT, Database, brief, is_about_data
from dock_gateway.storage.rows import Batch, Key
from dock_gateway.storage.spool import Entry, Spool
from dock_gateway.storage.waiting import Waiting, batch_of

log = logging.getLogger(__name__)

ANSWER_TIMEOUT = 0.1  # Seconds that a new goal waits for the database before it goes to the spool.
REFUSE_AFTER = 2.0  # Seconds to wait for the running write if the spool fails too.
BATCH_INTERVAL = 0.2  # Seconds to collect a batch before it is written.
BATCH_PATIENCE = 0.3  # Seconds that new goals, which are written first, may delay the rest.
# Seconds until entries that must be kept, and are not in the database yet, go to the spool.
SPOOL_AFTER = 0.5
SAY_AFTER = 2.0  # Seconds after which an access to the database that still runs is logged.
RETRY_FIRST, RETRY_LAST = 0.1, 2.0  # Seconds before the first retry, and at most.


class Writer:
    """Writes all goals and events.

    Args:
        database: The database to write to.
        spool: Takes entries while the database does not.
        waiting: The entries to write.
        on_loss: Called when the database has lost its data.
    """

    def __init__(self, database: Database, spool: Spool, waiting: Waiting, on_loss: Callable[[], None]) -> None:
        self.reachable = database.prepared
        # Why the database does not answer; None says that it does. Set while it is reachable, it is slow: it kept a
        # goal waiting and has not answered since.
        self.last_error: str | None = None if self.reachable else "the database has not been used yet"
        self.evicted = 0  # entries that are in the spool and no longer in memory
        self.answered = asyncio.Event()  # set after the first access to the database, successful or not
        self._database = database
        self._spool = spool
        self._waiting = waiting
        self._on_loss = on_loss
        self._running: tuple[str, float] | None = None  # what the database does, and since when
        self._waiting_since = 0.0
        self._tickets: dict[asyncio.Future[None], str] = {}  # one per waiter → id of its goal
        self._wake = asyncio.Event()
        self._urgent = asyncio.Event()
        self._guard = asyncio.Event()
        self._in_flight: set[str] = set()  # ids of the goals in the running transaction
        self._tasks: list[asyncio.Task[None]] = []

    def start(self) -> None:
        """Start the background tasks."""
        self._tasks = [asyncio.create_task(self._write_on())]
        if not self._database.volatile:
            self._tasks.append(asyncio.create_task(self._spool_on()))

    @property
    def answers(self) -> bool:
        """Whether the database is reachable and not slow. If not, `last_error` says why."""
        return self.last_error is None

    @property
    def awaited(self) -> str | None:
        """What the database does while it does not answer, without a full stop; None if it does nothing."""
        if self.answers or self._running is None:
            return None
        what, since = self._running
        return f"{what} has been running for {time.monotonic() - since:.1f} s"

    @contextmanager
    def _run(self, what: str) -> Iterator[None]:
        """Note what the database does meanwhile, and log it if it takes long."""
        self._running = (what, time.monotonic())
        saying = asyncio.get_running_loop().call_later(SAY_AFTER, self._say_running)
        try:
            yield
        finally:
            saying.cancel()
            self._running = None

    def _say_running(self) -> None:
        if (awaited := self.awaited) is not None:
            log.warning("the history database does not answer: %s", awaited)

    def notice(self, *, must_keep: bool) -> None:
        """Note that `waiting` has a new entry."""
        if not self._wake.is_set():
            self._waiting_since = time.monotonic()
            self._wake.set()
        if must_keep:
            self._guard.set()

    # ------------------------------------------------------------------ a new goal

    async def keep(self, goal: Goal, key: Key | None) -> None:
        """Store a new goal in the database or in the spool.

        Raises:
            Unavailable: Neither takes it.
        """
        ticket = asyncio.get_running_loop().create_future()
        self._tickets[ticket] = goal.goal_id
        try:
            await self._keep(goal, key, ticket)
        finally:
            del self._tickets[ticket]

    async def _keep(self, goal: Goal, key: Key | None, ticket: "asyncio.Future[None]") -> None:
        kept = self._waiting.put_goal(goal)
        if key is not None:
            self._waiting.put_key(key)
        self.notice(must_keep=True)
        if self._database.volatile:
            return
        self._urgent.set()
        if self.answers:
            with suppress(*DATABASE_ERRORS):
                async with asyncio.timeout(ANSWER_TIMEOUT):
                    await asyncio.shield(ticket)
                return
            self.last_error = self.last_error or f"no answer within {ANSWER_TIMEOUT * 1000:.0f} ms"
        entries: list[Entry] = [kept] if key is None else [key, kept]
        try:
            await self._append(entries)
        except OSError as error:
            if ticket.done() and not ticket.cancelled() and ticket.exception() is None:
                return
            self._waiting.forget_goal(goal.goal_id)
            if goal.goal_id in self._in_flight and await self._is_written(goal.goal_id):
                return
            log.error("a goal can be stored neither in the database (%s) nor in the spool (%s)", self.last_error, error)
            raise Unavailable("the goal cannot be stored, so it must not run", code="history_unavailable") from error
        self._waiting.saved(entries)
        self._wake.set()

    async def _is_written(self, goal_id: str) -> bool:
        """Return whether the running transaction stores a goal; a refused goal must not appear in the history."""
        ticket = asyncio.get_running_loop().create_future()
        self._tickets[ticket] = goal_id
        try:
            async with asyncio.timeout(REFUSE_AFTER):
                await ticket
        except DATABASE_ERRORS:
            return False
        finally:
            del self._tickets[ticket]
        return True

    def _settle(self, batch: Batch, error: Exception | None) -> None:
        written = {goal.goal_id for goal in batch.goals}
        for ticket, goal_id in self._tickets.items():
            if goal_id in written and not ticket.done():
                ticket.set_result(None) if error is None else ticket.set_exception(error)
                ticket.exception()  # mark it as retrieved; the waiter may be gone

    # ------------------------------------------------------------------ the database

    async def _write_on(self) -> None:
        pause = 0.0
        while True:
            if pause:
                await asyncio.sleep(pause)
            else:
                await self._wake.wait()
                with suppress(TimeoutError):
                    async with asyncio.timeout(BATCH_INTERVAL):
                        await self._urgent.wait()
            # Write new goals first, unless the rest has waited too long.
            fresh = time.monotonic() - self._waiting_since < BATCH_PATIENCE
            urgent = self._urgent.is_set() and self.reachable and fresh
            self._urgent.clear()
            if not urgent:
                self._wake.clear()
            pause = 0.0 if await self.flush(urgent=urgent) else min(max(2 * pause, RETRY_FIRST), RETRY_LAST)

    async def flush(self, *, urgent: bool = False) -> bool:
        """Write all pending entries, or only the awaited goals if `urgent`; return False if the database fails."""
        try:
            if not self._database.prepared:
                with self._run("the opening of the database"):
                    async with asyncio.timeout(WRITE_TIMEOUT):
                        await self._database.prepare()
            if self._database.lost:
                self._database.lost = False
                self._on_loss()
            await self._write_waiting(urgent=urgent)
            if not urgent:
                await self._empty_spool()
        except Exception as error:
            if not isinstance(error, DATABASE_ERRORS):
                log.exception("while writing the history")
            self._say_unreachable(error)
            return False
        finally:
            self.answered.set()
        return True

    async def _write_waiting(self, *, urgent: bool = False) -> None:
        while len(batch := self._waiting.urgent(self._tickets.values()) if urgent else self._waiting.batch()) or (
            not self.reachable
        ):
            self._in_flight = {goal.goal_id for goal in batch.goals}
            try:
                await self._write(batch)
            except Exception as error:
                self._settle(batch, error)
                raise
            finally:
                self._in_flight = set()
            self._waiting.done(batch)
            self._settle(batch, None)
            self._say_reachable()
            if not batch.full:
                break

    async def _write(self, batch: Batch) -> None:
        try:
            with self._run("a write"):
                async with asyncio.timeout(WRITE_TIMEOUT):
                    await self._database.write(queries.write, batch, durable=batch.must_keep)
        except (sa_errors.StatementError, ValueError) as error:
            if not is_about_data(error):
                raise
            await self._write_one_by_one(batch)

    async def _write_one_by_one(self, batch: Batch) -> None:
        """Write each entry alone, because the database refuses one of them; log that one."""
        for part in batch.split():
            try:
                with self._run("a write"):
                    async with asyncio.timeout(WRITE_TIMEOUT):
                        await self._database.write(queries.write, part)
            except (sa_errors.StatementError, ValueError) as error:
                if not is_about_data(error):
                    raise
                log.error("the database refuses %s: %s", part, error)

    async def _empty_spool(self) -> None:
        """Remove the spool's files once the database has their entries."""
        if not self._spool.count:
            return
        evicted = self.evicted
        paths = await self._spool.rotate()
        # An entry is in memory before it is in a file: what these files hold is written here, or was evicted.
        await self._write_waiting()
        if evicted:
            async for entries in self._spool.read(paths):
                await self._write(batch_of(entries))
                await asyncio.sleep(0)
        if self.evicted > evicted:
            return  # entries of these files were evicted meanwhile; they are read next time
        self.evicted = 0
        await self._spool.remove(paths)
        log.info("all spooled entries are in the database")

    def _say_reachable(self) -> None:
        if not self.reachable:
            log.info("the history database answers")
        self.reachable = True
        self.last_error = None

    def _say_unreachable(self, error: Exception) -> None:
        self.last_error = brief(error)
        if self.reachable or not self.answered.is_set():
            log.warning("the history database does not answer; goals go to the spool: %s", self.last_error)
        self.reachable = False

    def doubt(self, error: Exception) -> bool:
        """Check the database after an access failed; return False if it was the data that the database refused."""
        if is_about_data(error):
            log.error("the database refuses a value: %s", brief(error))
            return False
        if self.reachable:
            self._say_unreachable(error)
        self._wake.set()
        self._urgent.set()
        return True

    # ------------------------------------------------------------------ the spool

    async def _spool_on(self) -> None:
        complained = -60.0
        while True:
            await self._guard.wait()
            self._guard.clear()
            await asyncio.sleep(SPOOL_AFTER)
            try:
                await self.save()
            except OSError as error:
                self._guard.set()
                self._waiting.shed()
                if time.monotonic() - complained > 60.0:
                    complained = time.monotonic()
                    log.error("the spool cannot be written: %s", error)

    async def save(self) -> None:
        """Append the entries that are only in memory to the spool, and evict the excess."""
        entries = self._waiting.unspooled()
        if entries:
            await self._append(entries)
            self._waiting.saved(entries)
        self.evicted += self._waiting.evict()
        self._wake.set()

    async def _append(self, entries: list[Entry]) -> None:
        await self._spool.append(entries)
        if self._spool.lost:
            self._spool.lost = False
            self._waiting.forget_spool()
            self._guard.set()

    async def take_over(self) -> None:
        """Load what earlier processes left in the spool."""
        try:
            paths = await self._spool.take_over()
            async for entries in self._spool.read(paths):
                for entry in entries:
                    self._waiting.put(entry, safe=True)
                self.evicted += self._waiting.evict()
        except OSError as error:
            log.error("the spool cannot be read: %s", error)
        if self._spool.count:
            log.info("%d spooled entries wait for the database", self._spool.count)
        self._wake.set()
        self._urgent.set()

    async def close(self, timeout: float) -> None:
        """Write the pending entries for `timeout` seconds, and spool the rest."""
        for task in self._tasks:
            task.cancel()
        self._waiting.held.clear()
        last = asyncio.create_task(self._write_last())
        await asyncio.wait([last], timeout=timeout)
        last.cancel()
        try:
            await self.save()
        except OSError as error:
            log.error("%d entries are lost: the spool cannot be written: %s", len(self._waiting.unspooled()), error)
        with suppress(OSError):
            await self._spool.close()

    async def _write_last(self) -> None:
        await asyncio.gather(*self._tasks, return_exceptions=True)
        if self._waiting.anything or self._spool.count:
            await self.flush()
