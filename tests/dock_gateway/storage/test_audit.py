"""The audit log in each history: one chain whoever writes, and whatever is done to a row is found."""

import asyncio
import signal
import subprocess
import sys
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from datetime import timedelta
from pathlib import Path
from typing import Any

import pytest
import sqlalchemy as sa

from dock_gateway.core.audit import AuditFilter, RequestOutcome, Verdict
from dock_gateway.core.errors import Unavailable
from dock_gateway.core.event import utc_now
from dock_gateway.storage import History, audit, immediate, sqlite
from dock_gateway.storage.history import open_database
from tests.support.audit import NOON, change, make_entry, statement
from tests.support.history import history_at, locked, open_place
from tests.support.waiting import PATIENCE, until

APPENDER = [sys.executable, "-m", "tests.support.audit"]


pytestmark = pytest.mark.usefixtures("patient")


@asynccontextmanager
async def opened(url: str, folder: Path, **limits: Any) -> AsyncIterator[History]:
    async with open_place(url, folder, **limits) as history:
        await until(lambda: history.stats().database_reachable)
        yield history


async def check(url: str, expected: str | None = None) -> Verdict:
    database = open_database(url)
    try:
        await database.prepare()
        return await database.read(audit.check, expected)
    finally:
        await database.close()


async def sequences(history: History, **wanted: Any) -> list[int]:
    return [row.sequence for row in await history.audit.page(AuditFilter(**wanted), limit=100)]


async def test_entries_are_stored_once_and_read_as_they_were(place: str, tmp_path: Path) -> None:
    entries = [make_entry(1), make_entry(2, subject='Zoë\'s "rule" 🤖', request_id="r1", code="x", status=409)]
    async with opened(place, tmp_path) as history:
        added = await history.audit.append(entries)
        assert [row.sequence for row in added] == [1, 2]
        assert await history.audit.page(AuditFilter(), limit=10) == added[::-1]
        assert [row.entry for row in added] == entries


async def test_a_write_that_is_repeated_stores_nothing_twice(database_url: str, tmp_path: Path) -> None:
    async with opened(database_url, tmp_path) as history:
        await history.audit.append([make_entry(1), make_entry(2)])
        again = await history.audit.append([make_entry(2), make_entry(3)])
        assert [(row.sequence, row.entry) for row in again] == [(3, make_entry(3))]
        assert await sequences(history) == [3, 2, 1]
    assert (await check(database_url)).intact == 3


@pytest.mark.parametrize(
    ("wanted", "found"),
    [
        ({"principal": "ada"}, [3, 1]),
        ({"principal": "ad%"}, []),
        ({"what": "stop"}, [2]),
        ({"robot": "/robot1"}, [3, 2, 1]),
        ({"robot": "/robot_"}, []),
        ({"robot": "/a_b"}, [2]),
        ({"goal_id": "g3"}, [3]),
        ({"outcome": RequestOutcome.DONE}, [1]),
        ({"outcome": RequestOutcome.REFUSED}, [2]),
        ({"outcome": RequestOutcome.FAILED}, [3]),
        ({"since": NOON + timedelta(seconds=2)}, [3, 2]),
        ({"until": NOON + timedelta(seconds=2)}, [1]),
        ({"principal": "ada", "outcome": RequestOutcome.DONE, "robot": "/robot2"}, []),
    ],
)
async def test_filters(place: str, tmp_path: Path, wanted: dict[str, Any], found: list[int]) -> None:
    async with opened(place, tmp_path) as history:
        await history.audit.append(
            [
                make_entry(1),
                make_entry(2, principal="bob", what="stop", robot="/robot1,/a_b", status=404),
                make_entry(3, goal_id="g3", status=503),
            ]
        )
        assert await sequences(history, **wanted) == found


async def test_pages(place: str, tmp_path: Path) -> None:
    async with opened(place, tmp_path) as history:
        await history.audit.append([make_entry(number) for number in range(5)])
        first = await history.audit.page(AuditFilter(), limit=2)
        second = await history.audit.page(AuditFilter(), limit=2, before=first[-1].sequence)
        assert [row.sequence for row in (*first, *second)] == [5, 4, 3, 2]


@pytest.mark.parametrize(
    ("tampering", "intact", "fault"),
    [
        ("UPDATE audit SET principal = 'eve' WHERE sequence = 3", 2, "row 3 was changed"),
        ("UPDATE audit SET code = NULL, status = 200 WHERE sequence = 5", 4, "row 5 was changed"),
        ("DELETE FROM audit WHERE sequence = 3", 2, "row 3 was removed"),
        ("DELETE FROM audit WHERE sequence IN (2, 3)", 1, "rows 2 to 3 were removed"),
        ("DELETE FROM audit WHERE sequence = 1", 0, "row 1 was removed"),
        ("DELETE FROM audit WHERE sequence = 5", 4, "row 5 was removed"),
        ("DELETE FROM audit", 0, "rows 1 to 5 were removed"),
        ("DELETE FROM audit_chain", 0, "audit_chain is empty"),
        ("UPDATE audit_chain SET head_sequence = 4", 5, "is not the one that a gateway wrote last"),
        ("UPDATE audit SET sequence = sequence + 10 WHERE sequence = 5", 4, "rows 5 to 14 were removed"),
    ],
)
async def test_tampering_is_found(database_url: str, tmp_path: Path, tampering: str, intact: int, fault: str) -> None:
    async with opened(database_url, tmp_path) as history:
        await history.audit.append([make_entry(number, status=409, code="busy") for number in range(5)])
    assert (await check(database_url)).fault is None
    await change(database_url, statement(tampering))
    verdict = await check(database_url)
    assert verdict.intact == intact
    assert fault in (verdict.fault or "")


async def test_swapped_and_inserted_rows_are_found_and_do_not_stop_the_gateway(
    database_url: str, tmp_path: Path
) -> None:
    def swap(connection: sa.Connection) -> None:
        for old, new in ((2, 0), (4, 2), (0, 4)):
            connection.execute(sa.text(f"UPDATE audit SET sequence = {new} WHERE sequence = {old}"))

    def insert(connection: sa.Connection) -> None:
        columns, values = "acted_at, what, status, digest", "FROM audit WHERE sequence = 5"
        connection.execute(sa.text(f"INSERT INTO audit (sequence, id, {columns}) SELECT 6, 'x', {columns} {values}"))

    async with opened(database_url, tmp_path) as history:
        await history.audit.append([make_entry(number) for number in range(5)])
        await change(database_url, insert)
        assert [row.sequence for row in await history.audit.append([make_entry(9)])] == [7]
        verdict = await check(database_url)
        assert (verdict.intact, (verdict.fault or "")[:5]) == (5, "row 6")
        await change(database_url, swap)
        verdict = await check(database_url)
        assert (verdict.intact, (verdict.fault or "")[:5]) == (1, "row 2")


async def test_a_row_that_cannot_be_read_is_a_fault(sqlite_url: str, tmp_path: Path) -> None:
    async with opened(sqlite_url, tmp_path) as history:
        await history.audit.append([make_entry(1)])
    await change(sqlite_url, statement("UPDATE audit SET acted_at = 'noon'"))
    assert "cannot be read" in ((await check(sqlite_url)).fault or "")


async def test_the_oldest_rows_are_deleted_and_the_rest_is_still_a_chain(database_url: str, tmp_path: Path) -> None:
    old, now = utc_now() - timedelta(days=2), utc_now()
    entries = [make_entry(number, acted_at=old if number < 4 else now) for number in range(8)]
    async with opened(database_url, tmp_path, audit_age=86_400) as history:
        await history.audit.append(entries)
        await history.retention.enforce()
        assert await sequences(history) == [8, 7, 6, 5]
        assert await check(database_url) == Verdict(4, (await history.audit.page(AuditFilter(), limit=1))[0].link)
        await history.audit.append([make_entry(9)])
        assert (await check(database_url)).intact == 5
    await change(database_url, statement("DELETE FROM audit WHERE sequence = 5"))
    assert (await check(database_url)).fault == "row 5 was removed"


async def test_more_than_the_limit_are_deleted_also_in_several_transactions(database_url: str, tmp_path: Path) -> None:
    count = 2 * audit.CHUNK + 5
    async with opened(database_url, tmp_path, audit_entries=2) as history:
        await history.audit.append([make_entry(number, acted_at=utc_now()) for number in range(count)])
        await history.retention.enforce()
        assert await sequences(history) == [count, count - 1]
        verdict = await check(database_url)
        assert (verdict.intact, verdict.fault) == (2, None)


async def test_goals_may_go_and_the_audit_stays(database_url: str, tmp_path: Path) -> None:
    async with opened(database_url, tmp_path, goal_age=1, goal_bytes=1, event_age=1, event_bytes=1) as history:
        await history.audit.append([make_entry(1)])
        await history.retention.enforce()
        assert await sequences(history) == [1]


async def test_a_database_that_does_not_answer(sqlite_url: str, tmp_path: Path, monkeypatch: Any) -> None:
    async with opened(sqlite_url, tmp_path) as history:
        await history.audit.append([make_entry(1)])
        monkeypatch.setattr(immediate, "WRITE_TIMEOUT", 0.2)
        monkeypatch.setattr(sqlite, "BUSY_TIMEOUT", 0.2)
        with locked(sqlite_url.removeprefix("sqlite:///")), pytest.raises(Unavailable):
            await history.audit.append([make_entry(2)])
        monkeypatch.setattr(immediate, "WRITE_TIMEOUT", PATIENCE)
        await until(lambda: history.stats().database_reachable)
        await history.audit.append([make_entry(2)])
        assert await sequences(history) == [2, 1]


async def test_two_histories_make_one_chain(database_url: str, tmp_path: Path) -> None:
    async with (
        opened(database_url, tmp_path / "a") as first,
        opened(database_url, tmp_path / "b") as second,
    ):

        async def write(history: History, start: int) -> None:
            for number in range(start, start + 30):
                await history.audit.append([make_entry(number)])

        await asyncio.gather(write(first, 0), write(second, 100), write(first, 200), write(second, 300))
        assert (await check(database_url)).intact == 120


def test_killed_processes_leave_a_whole_chain(database_url: str, tmp_path: Path) -> None:
    """Each is killed while it writes, in turn, and what it has said to be stored is there."""
    stored = 0
    for number in range(3):
        command = [*APPENDER, database_url, str(tmp_path / str(number)), str(number * 100_000)]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
            assert process.stdout is not None
            for _ in range(20):
                assert process.stdout.readline().startswith("stored")
            process.send_signal(signal.SIGKILL)
            stored += 20 + len(process.stdout.readlines())
    verdict = asyncio.run(check(database_url))
    assert verdict.fault is None
    assert verdict.intact >= stored


def test_the_history_is_not_open_yet(sqlite_url: str, tmp_path: Path) -> None:
    async def append() -> None:
        with pytest.raises(Unavailable):
            await history_at(sqlite_url, tmp_path).audit.append([make_entry(1)])

    asyncio.run(append())
