"""The audit log of this gateway: entries wait in memory, and on disk, until the history has stored them."""

import asyncio
import logging
from collections.abc import Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from itertools import islice

import orjson

from dock_gateway.audit.record import RequestRecord, remark
from dock_gateway.core.audit import AuditEntry, AuditRow
from dock_gateway.core.errors import Unavailable
from dock_gateway.core.tasks import Tasks
from dock_gateway.storage import AuditSpool, AuditStore

log = logging.getLogger("dock_gateway.audit")

BATCH = 500  # entries per transaction
RETRY_FIRST, RETRY_LAST = 0.1, 2.0  # seconds before the first retry, and at most
CLOSE_TIMEOUT = 1.0  # seconds for the history, and as many for the spool


@dataclass(frozen=True)
class AuditLimits:
    """Limits and timeouts of the audit log. Times are in seconds.

    Attributes:
        waiting: Entries in memory; more are lost, and counted.
        batch_interval: Time to collect a batch, unless an answer waits for it.
        answer_timeout: How long an answer waits until its entry is stored.
    """

    waiting: int = 10_000
    batch_interval: float = 0.2
    answer_timeout: float = 0.5


LIMITS = AuditLimits()


class AuditLog:
    """Stores the record of requests in batches, in the order in which they came.

    Each entry is also logged, once: with its digest when it is stored, or without it if that takes longer.

    While the history does not answer, entries are in the spool as well, so that they outlast this process.

    Args:
        record: The record of requests.
        store: Stores its entries.
        spool: Keeps them on disk until they are stored; None: nowhere.
        limits: How much it takes.
    """

    def __init__(
        self,
        record: RequestRecord,
        store: AuditStore,
        spool: AuditSpool | None = None,
        limits: AuditLimits = LIMITS,
    ) -> None:
        self._limits = limits
        self._record = record
        self.lost = 0  # entries since the start
        self._store = store
        self._spool = spool
        self._spooled: set[str] = set()  # which of those that wait are in the spool
        self._complained = False  # that the spool cannot be written
        self._waiting: dict[str, AuditEntry] = {}
        self._logged: set[str] = set()  # which of them
        self._tickets: dict[str, asyncio.Future[None]] = {}  # of answers, by entry id
        self._unreported = 0  # lost entries that no entry says yet
        self.answering = True  # whether the history took the last batch
        self._wake = asyncio.Event()
        self._urgent = asyncio.Event()
        self._tasks = Tasks("writing the audit log")
        self._listening = ExitStack()

    async def open(self) -> None:
        """Take over what earlier processes left in the spool, and start to write."""
        if self._spool is not None:
            try:
                async for entries in self._spool.read(await self._spool.take_over()):
                    self._waiting.update((entry.id, entry) for entry in entries)
            except OSError as error:
                log.error("the spool of the audit log cannot be read: %s", error)
        if self._waiting:
            log.info("%d entries of an earlier process wait for the history", len(self._waiting))
            self._spooled.update(self._waiting)
            self._wake.set()
        self._tasks.spawn(self._write_on())
        self._listening.enter_context(self._record.on_entry.adding(self._put))
        self._listening.enter_context(self._record.until_stored.adding(self.until_stored))

    def __len__(self) -> int:
        return len(self._waiting)

    async def until_stored(self, entry: AuditEntry) -> None:
        """Wait until an entry is stored, for half a second at most and only if the history answers."""
        if not self.answering or entry.id not in self._waiting:
            return
        ticket = self._tickets[entry.id] = asyncio.get_running_loop().create_future()
        self._urgent.set()
        try:
            with suppress(TimeoutError):
                async with asyncio.timeout(self._limits.answer_timeout):
                    await ticket
        finally:
            del self._tickets[entry.id]

    def _put(self, entry: AuditEntry) -> None:
        if len(self._waiting) >= self._limits.waiting:
            self.lost += 1
            self._unreported += 1
            log.warning("an entry is lost, as %d wait for the history: %s", len(self._waiting), _text(entry))
            return
        self._waiting[entry.id] = entry
        self._wake.set()

    # ------------------------------------------------------------------ the history

    async def _write_on(self) -> None:
        pause = 0.0
        while True:
            if pause:
                await asyncio.sleep(pause)
            else:
                await self._wake.wait()
                with suppress(TimeoutError):
                    async with asyncio.timeout(self._limits.batch_interval):
                        await self._urgent.wait()
            if await self._flush():
                pause = 0.0
                await self._empty_spool()
            else:
                pause = min(max(2 * pause, RETRY_FIRST), RETRY_LAST)
                await self._save()

    async def _flush(self) -> bool:
        """Store all entries; return False if the history does not answer."""
        while self._waiting:
            self._urgent.clear()
            batch = list(islice(self._waiting.values(), BATCH))
            try:
                # Entries that no answer waits for are written without a sync to the disk, which goals wait for, too.
                durable = not self._tickets.keys().isdisjoint(entry.id for entry in batch)
                rows = await self._store.append(batch, durable=durable)
            except Exception as error:
                if not isinstance(error, Unavailable):
                    log.exception("while writing the audit log")
                self.answering = False
                self._log(batch, {})
                return False
            self.answering = True
            self._done(batch, rows)
        self._wake.clear()
        return True

    def _done(self, batch: Sequence[AuditEntry], rows: Sequence[AuditRow]) -> None:
        self._log(batch, {row.entry.id: row for row in rows})
        for entry in batch:
            del self._waiting[entry.id]
            self._spooled.discard(entry.id)
            self._logged.discard(entry.id)
            ticket = self._tickets.get(entry.id)
            if ticket is not None and not ticket.done():
                ticket.set_result(None)
        if self._unreported:
            self._record.on_entry(remark("entries_lost", f"{self._unreported} entries", 500, "entries_lost"))
            self._unreported = 0

    def _log(self, batch: Sequence[AuditEntry], rows: dict[str, AuditRow]) -> None:
        # Different messages, so that a flood of one kind does not keep the others out of the log.
        for entry in batch:
            if entry.id in self._logged:
                continue
            row = rows.get(entry.id)
            about = {"goal_id": entry.goal_id}
            if row is None:
                log.info("not stored yet: %s", _text(entry), extra=about)
            elif entry.status < 400:
                log.info("%s", _text(row), extra=about)
            else:
                log.info("not carried out: %s", _text(row), extra=about)
            self._logged.add(entry.id)

    # ------------------------------------------------------------------ the spool

    async def _save(self) -> None:
        """Append the entries that are only in memory to the spool."""
        if self._spool is None:
            return
        entries = [entry for key, entry in self._waiting.items() if key not in self._spooled]
        try:
            await self._spool.append(entries)
        except OSError as error:
            if not self._complained:
                log.error("the spool of the audit log cannot be written: %s", error)
            self._complained = True
            return
        self._complained = False
        if self._spool.lost:  # its file was deleted
            self._spool.lost = False
            self._spooled.clear()
        self._spooled.update(entry.id for entry in entries)

    async def _empty_spool(self) -> None:
        """Remove the spool's files, as the history has all that is in them."""
        if self._spool is not None and self._spool.count:
            await self._spool.remove(await self._spool.rotate())
            log.info("all spooled entries are stored")

    async def close(self) -> None:
        """Store the waiting entries, for one second at most; the rest goes to the spool."""
        with self._listening:
            await self._tasks.close()
            self._record.end_period()
            with suppress(TimeoutError):
                async with asyncio.timeout(CLOSE_TIMEOUT):
                    if await self._flush():
                        await self._empty_spool()
            with suppress(TimeoutError):
                async with asyncio.timeout(CLOSE_TIMEOUT):
                    await self._save()
        lost = len(self._waiting.keys() - self._spooled)
        if lost:
            log.error("%d entries are lost: the history does not answer", lost)
        if self._spool is not None:
            with suppress(OSError):
                await self._spool.close()


def _text(entry: AuditEntry | AuditRow) -> str:
    """Return an entry for the log: its fields that have a value, as JSON."""
    fields = entry.document() if isinstance(entry, AuditRow) else vars(entry)
    return orjson.dumps({name: value for name, value in fields.items() if value is not None}).decode()
