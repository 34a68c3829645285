"""Write-behind in batches: retries when the database fails, and spools what must be kept."""

import asyncio
import logging
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from copy import copy

import sqlalchemy.exc as sa_errors

from dock_gateway.core.errors import Unavailable
from dock_gateway.core.goal import Goal
from dock_gateway.storage import queries
from dock_gateway.storage.database import DATABASE_ERRORS, WRITE_TIMEOUT, Database, brief, is_about_data
from dock_gateway.storage.group_commit import GroupCommit
from dock_gateway.storage.rows import Batch, Entry, Key
from dock_gateway.storage.spool import Spool
from dock_gateway.storage.waiting import Name, WaitingEntries, batch_of

log = logging.getLogger(__name__)

ANSWER_TIMEOUT = 0.1  # Seconds that a new goal waits for the database before it goes to the spool.
REFUSE_AFTER = 2.0  # Seconds that it waits for the database after that if the spool fails too.
BATCH_INTERVAL = 0.2  # Seconds to collect a batch before it is written.
# Seconds between two looks at what must be kept and is only in memory: what is found a second time goes to the spool.
SPOOL_INTERVAL = 0.25
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

    def __init__(self, database: Database, spool: Spool, waiting: WaitingEntries, on_loss: Callable[[], None]) -> None:
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
        self._running: list[tuple[float, str]] = []  # what the database does, and since when
        self._new_goals = GroupCommit(self._write_new)
        self._wake = asyncio.Event()
        self._tasks: list[asyncio.Task[None]] = []

    def start(self) -> None:
        """Start the background tasks."""
        work = [self._write_on()]
        if not self._database.volatile:
            work += [self._new_goals.run(), self._spool_on()]
        self._tasks = [asyncio.create_task(each) for each in work]

    @property
    def answers(self) -> bool:
        """Whether the database is reachable and not slow. If not, `last_error` says why."""
        return self.last_error is None

    @property
    def awaited(self) -> str | None:
        """The activity of the database while it does not answer, without a full stop; None if there is none."""
        if self.answers or not self._running:
            return None
        since, what = min(self._running)
        return f"{what} has been running for {time.monotonic() - since:.1f} s"

    @contextmanager
    def _run(self, what: str) -> Iterator[None]:
        """Note what the database does within, and log it if it takes long."""
        begun = (time.monotonic(), what)
        self._running.append(begun)
        saying = asyncio.get_running_loop().call_later(SAY_AFTER, self._say_running)
        try:
            yield
        finally:
            saying.cancel()
            self._running.remove(begun)

    def _say_running(self) -> None:
        if (awaited := self.awaited) is not None:
            log.warning("the history database does not answer: %s", awaited)

    def notice(self) -> None:
        """Note that `waiting` has a new entry."""
        self._wake.set()

    # ------------------------------------------------------------------ a new goal

    async def keep(self, goal: Goal, key: Key | None) -> None:
        """Store a new goal in the database or in the spool.

        Raises:
            Unavailable: Neither takes it.
        """
        batch = Batch(goals=[copy(goal)], keys=[] if key is None else [key])
        if self._database.volatile or not await self._store(batch):
            for each in batch.keys:
                self._waiting.put_key(each, safe=True)
            # Not before: what waits is written, and the goal might be refused.
            self._waiting.put_goal(goal, safe=True)
            self.notice()

    async def _store(self, batch: Batch) -> bool:
        """Store a batch in the database, or else in the spool; return whether the database has it."""
        stored = self._new_goals.commit(batch) if self.answers else None
        try:
            if stored is not None:
                if await _succeeds(stored, ANSWER_TIMEOUT):
                    return True
                self.last_error = self.last_error or f"no answer within {ANSWER_TIMEOUT * 1000:.0f} ms"
            await self._append([*batch.keys, *batch.goals])
        except OSError as error:
            if stored is not None and await _succeeds(stored, REFUSE_AFTER):
                return True
            log.error("a goal can be stored neither in the database (%s) nor in the spool (%s)", self.last_error, error)
            raise Unavailable("the goal cannot be stored, so it must not run", code="history_unavailable") from error
        finally:
            if stored is not None:
                stored.cancel()
        return False

    async def _write_new(self, batch: Batch) -> None:
        try:
            await self._write(batch)
        except Exception as error:
            self.doubt(error)
            raise
        self._say_reachable()

    # ------------------------------------------------------------------ the database

    async def _write_on(self) -> None:
        pause = 0.0
        while True:
            self._wake.clear()
            if await self.flush():
                pause = 0.0
                await self._wake.wait()
                await asyncio.sleep(BATCH_INTERVAL)
            else:
                pause = min(max(2 * pause, RETRY_FIRST), RETRY_LAST)
                await asyncio.sleep(pause)

    async def flush(self) -> bool:
        """Write all pending entries; return False if the database fails."""
        try:
            if not self._database.prepared:
                with self._run("the opening of the database"):
                    async with asyncio.timeout(WRITE_TIMEOUT):
                        await self._database.prepare()
            if self._database.lost:
                self._database.lost = False
                self._on_loss()
            await self._write_waiting()
            await self._empty_spool()
        except Exception as error:
            if not isinstance(error, DATABASE_ERRORS):
                log.exception("while writing the history")
            self._say_unreachable(error)
            return False
        finally:
            self.answered.set()
        return True

    async def _write_waiting(self) -> set[str]:
        """Write all that waits, except goals that are held; return the ids of the goals."""
        written: set[str] = set()
        while len(batch := self._waiting.batch()) or not self.reachable:
            await self._write(batch)
            self._waiting.done(batch)
            self._say_reachable()
            written.update(goal.goal_id for goal in batch.goals)
            if not batch.full:
                break
        return written

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
        # What these files hold is in memory, was evicted, or is in the database: after an append, which was before the
        # rotation, `keep` has gone on, too.
        left = set(self._waiting.goals)
        left -= await self._write_waiting()
        if evicted:
            async for entries in self._spool.read(paths):
                await self._write(batch_of(entries))
                await asyncio.sleep(0)
        if self.evicted > evicted or left:
            return  # entries of these files were evicted or held meanwhile; next time
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
        return True

    # ------------------------------------------------------------------ the spool

    async def _spool_on(self) -> None:
        complained = -60.0
        while True:
            earlier = self._waiting.unspooled().keys()
            await asyncio.sleep(SPOOL_INTERVAL)
            still = {name: entry for name, entry in self._waiting.unspooled().items() if name in earlier}
            try:
                await self._save(still)
            except OSError as error:
                self._waiting.shed()
                if time.monotonic() - complained > 60.0:
                    complained = time.monotonic()
                    log.error("the spool cannot be written: %s", error)

    async def _save(self, entries: Mapping[Name, Entry]) -> None:
        """Append entries to the spool, and evict the excess."""
        if entries:
            await self._append(list(entries.values()))
            self._waiting.saved(entries)
            self._wake.set()
        self.evicted += self._waiting.evict()

    async def _append(self, entries: list[Entry]) -> None:
        await self._spool.append(entries)
        if self._spool.lost:
            self._spool.lost = False
            self._waiting.forget_spool()

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

    async def close(self, timeout: float) -> None:
        """Write the pending entries for `timeout` seconds, and spool the rest."""
        for task in self._tasks:
            task.cancel()
        self._waiting.held.clear()
        last = asyncio.create_task(self._write_last())
        await asyncio.wait([last], timeout=timeout)
        last.cancel()
        try:
            await self._save(self._waiting.unspooled())
        except OSError as error:
            log.error("%d entries are lost: the spool cannot be written: %s", len(self._waiting.unspooled()), error)
        with suppress(OSError):
            await self._spool.close()

    async def _write_last(self) -> None:
        await asyncio.gather(*self._tasks, return_exceptions=True)
        if self._waiting.anything or self._spool.count:
            await self.flush()


async def _succeeds(stored: "asyncio.Future[None]", timeout: float) -> bool:
    """Wait for a commit; return whether it is done, and without an error."""
    await asyncio.wait([stored], timeout=timeout)
    return stored.done() and stored.exception() is None
