"""The audit log: nothing waits for it but the answers that shall, and what it cannot keep is counted."""

import asyncio
import logging
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager
from pathlib import Path

import orjson
import pytest

from dock_gateway.audit.record import RECORD_LIMITS, RequestRecord
from dock_gateway.core.audit import START, AuditEntry, AuditFilter, AuditRow, extend
from dock_gateway.core.errors import Unavailable
from dock_gateway.extensions.audit_log.log import LIMITS, AuditLimits, AuditLog
from dock_gateway.storage import AuditSpool
from tests.support.audit import make_entry
from tests.support.history import timed
from tests.support.waiting import PATIENCE, until


class Store:
    """Keeps rows in a list; can be away, and slow."""

    def __init__(self) -> None:
        self._rows: list[AuditRow] = []
        self.away = False
        self.answering = asyncio.Event()
        self.answering.set()
        self.batches: list[int] = []
        self.durable: list[bool] = []

    async def append(self, entries: Sequence[AuditEntry], *, durable: bool = True) -> list[AuditRow]:
        await self.answering.wait()
        if self.away:
            raise Unavailable("away", code="history_unavailable")
        self.batches.append(len(entries))
        self.durable.append(durable)
        added = list(extend(self._rows[-1].link if self._rows else START, entries))
        self._rows += added
        return added

    async def page(self, wanted: AuditFilter, *, limit: int, before: int | None = None) -> list[AuditRow]:
        return self._rows[::-1][:limit]

    async def stored(self) -> list[AuditEntry]:
        return [row.entry for row in (await self.page(AuditFilter(), limit=100_000))[::-1]]


@pytest.fixture
def store() -> Store:
    return Store()


class Recorded:
    """A log, and what it follows."""

    def __init__(self, store: Store, spool: AuditSpool | None = None, limits: AuditLimits = LIMITS) -> None:
        requests = RequestRecord()
        self.record, self.store = requests.record, requests.store
        self.listening = requests.on_entry, requests.until_stored
        self.log = AuditLog(requests, store, spool, limits)

    def __len__(self) -> int:
        return len(self.log)


@asynccontextmanager
async def opened(store: Store, folder: Path | None = None, limits: AuditLimits = LIMITS) -> AsyncIterator["Recorded"]:
    audit = Recorded(store, None if folder is None else AuditSpool(folder), limits)
    await audit.log.open()
    try:
        yield audit
    finally:
        await audit.log.close()


async def test_entries_are_stored_in_their_order_soon(store: Store) -> None:
    entries = [make_entry(number, principal=f"user {number % 3}") for number in range(1200)]
    async with opened(store) as audit:
        for entry in entries:
            audit.record(entry)
        await until(lambda: not len(audit))
    assert await store.stored() == entries
    assert store.batches == [500, 500, 200]
    assert not any(audit.listening)


async def test_an_answer_goes_out_after_its_entry_is_stored(store: Store) -> None:
    store.answering.clear()
    async with opened(store) as audit:
        waiting = asyncio.create_task(audit.store(make_entry(1)))
        await asyncio.sleep(0)
        assert not waiting.done()
        store.answering.set()
        await waiting
        assert await store.stored() == [make_entry(1)]
        audit.record(make_entry(2))
        await until(lambda: not len(audit))
    assert store.durable == [True, False]


async def test_it_is_stored_at_once(store: Store) -> None:
    """It does not wait for a batch to fill."""
    async with opened(store, limits=AuditLimits(batch_interval=1000.0, answer_timeout=1000.0)) as audit:
        audit.record(make_entry(1))
        async with asyncio.timeout(PATIENCE):
            await audit.store(make_entry(2))
        assert store.batches == [2]


async def test_while_the_history_is_away_an_answer_waits_once_and_entries_are_kept(store: Store) -> None:
    store.answering.clear()
    async with opened(store) as audit:
        assert 0.4 < await timed(audit.store(make_entry(1))) < PATIENCE
        store.away = True
        store.answering.set()
        await until(lambda: not audit.log.answering)
        async with asyncio.timeout(0.3):  # it is known to be away
            await audit.store(make_entry(2))
        audit.record(make_entry(3))
        assert len(audit) == 3
        store.away = False
        await until(lambda: not len(audit))
        assert await store.stored() == [make_entry(1), make_entry(2), make_entry(3)]
        await audit.store(make_entry(4))
        assert (await store.stored())[-1] == make_entry(4)


async def test_an_error_of_the_store_ends_nothing(
    store: Store, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    original = store.append

    async def fail(_: Sequence[AuditEntry], *, durable: bool = True) -> list[AuditRow]:
        raise RuntimeError("a bug")

    monkeypatch.setattr(store, "append", fail)
    async with opened(store) as audit:
        audit.record(make_entry(1))
        await until(lambda: "a bug" in caplog.text)
        monkeypatch.setattr(store, "append", original)
        await until(lambda: not len(audit))
    assert await store.stored() == [make_entry(1)]


async def test_beyond_the_limit_entries_are_lost_and_the_log_says_so(store: Store) -> None:
    store.away = True
    async with opened(store, limits=AuditLimits(waiting=10)) as audit:
        for number in range(17):
            audit.record(make_entry(number))
        assert (len(audit), audit.log.lost) == (10, 7)
        store.away = False
        await until(lambda: not len(audit))
    *kept, remark = await store.stored()
    assert kept == [make_entry(number) for number in range(10)]
    assert (remark.what, remark.subject, remark.outcome) == ("entries_lost", "7 entries", "failed")


async def test_closing_stores_what_waits(store: Store) -> None:
    async with opened(store) as audit:
        for number in range(RECORD_LIMITS.unknown + 2):
            audit.record(make_entry(number, role=None))
    stored = await store.stored()
    assert len(stored) == RECORD_LIMITS.unknown + 1
    assert stored[-1].subject == "2 more requests without a valid token"


async def test_closing_does_not_wait_for_a_history_that_is_away(store: Store, caplog: pytest.LogCaptureFixture) -> None:
    store.answering.clear()
    audit = Recorded(store)
    await audit.log.open()
    audit.record(make_entry(1))
    assert await timed(audit.log.close()) < PATIENCE
    assert "1 entries are lost" in caplog.text


async def test_what_waits_outlasts_the_process(store: Store, tmp_path: Path) -> None:
    store.away = True
    async with opened(store, tmp_path) as audit:
        audit.record(make_entry(1, subject='a "name"\nof two lines'))
        await until(lambda: list(tmp_path.glob("*.jsonl")))  # while it runs: a kill loses nothing then
        audit.record(make_entry(2))
    async with opened(store, tmp_path) as audit:  # the history is still away
        audit.record(make_entry(3))
        assert len(audit) == 3
    store.away = False
    async with opened(store, tmp_path) as audit:
        await until(lambda: not len(audit) and not list(tmp_path.iterdir()))
        await audit.store(make_entry(4))
    first, *others = await store.stored()
    assert first == make_entry(1, subject='a "name"\nof two lines')
    assert others == [make_entry(2), make_entry(3), make_entry(4)]


async def test_two_gateways_do_not_take_each_others_entries(store: Store, tmp_path: Path) -> None:
    store.away = True
    async with opened(store, tmp_path) as audit:
        audit.record(make_entry(1))
        await until(lambda: list(tmp_path.glob("*.jsonl")))
        async with opened(store, tmp_path) as other:
            assert len(other) == 0


async def test_a_spool_that_cannot_be_written_ends_nothing(
    store: Store, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    (tmp_path / "file").touch()
    store.away = True
    async with opened(store, tmp_path / "file" / "spool") as audit:
        audit.record(make_entry(1))
        await until(lambda: "cannot be written" in caplog.text)
        store.away = False
        await until(lambda: not len(audit))
    assert await store.stored() == [make_entry(1)]


async def test_each_entry_is_logged_once_with_its_digest(store: Store, caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.INFO, "dock_gateway.audit")
    async with opened(store) as audit:
        await audit.store(make_entry(1, subject='a "name"\nof two lines'))
        store.away = True
        audit.record(make_entry(2, status=403, code="role_required"))
        await until(lambda: len(caplog.messages) == 2)
        store.away = False
        await until(lambda: not len(audit))
        await audit.store(make_entry(3, status=403, code="role_required"))
    first, second, third = caplog.messages
    document = orjson.loads(first)
    assert document["digest"] == (await store.page(AuditFilter(), limit=3))[-1].digest
    assert document["subject"] == 'a "name"\nof two lines'
    assert "\n" not in first
    assert orjson.loads(second.removeprefix("not stored yet: "))["id"] == make_entry(2).id
    assert orjson.loads(third.removeprefix("not carried out: "))["sequence"] == 3
