"""The database slow, locked, frozen, full or away: no goal waits for it, and none is lost."""

import asyncio
import itertools
import shutil
import threading
import time
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from functools import partial
from pathlib import Path
from typing import Any

import pytest
import sqlalchemy as sa

from dock_gateway.core.errors import Unavailable
from dock_gateway.core.goal import Goal, GoalStatus
from dock_gateway.core.tasks import cancel
from dock_gateway.storage import GoalFilter, History, queries, writer
from dock_gateway.storage.database import brief
from dock_gateway.storage.sqlite import SqliteDatabase
from tests.dock_gateway.storage.conftest import Outage, stopped
from tests.support.history import EVERYTHING, history_at, locked, make_event, make_goal, open_at, timed, written
from tests.support.postgresql import PostgreSQL
from tests.support.waiting import until

# Seconds that a busy machine may take where 100 ms are waited for the database. A transaction may take 10 s.
QUICK = 5.0
BARRED = "the history database does not answer"


@pytest.fixture(autouse=True)
def history_timeouts() -> None:
    """As installed: the tests here are about it."""


@pytest.fixture(autouse=True)
async def nothing_under_way() -> AsyncIterator[None]:
    """What a closed history leaves behind, such as a connection that waits for a lock, ends before the loop does."""
    yield
    await until(lambda: len(asyncio.all_tasks()) == 1, 20)


@asynccontextmanager
async def happening(outage: Outage) -> AsyncIterator[None]:
    """The outage, beside the loop: what the history has begun goes on to its end before the file can be locked."""
    manager = outage()
    await asyncio.to_thread(manager.__enter__)
    try:
        yield
    finally:
        await asyncio.to_thread(manager.__exit__, None, None, None)


async def test_an_outage_has_a_reason_from_its_first_moment_on(outage: tuple[str, Outage], tmp_path: Path) -> None:
    url, not_answering = outage
    reasons: set[str | None] = set()

    def look(history: History) -> bool:
        stats = history.stats()
        if not stats.database_reachable:
            reasons.add(stats.last_error)
        return stats.database_reachable

    async with happening(not_answering), open_at(url, tmp_path) as history:
        look(history)
        adding = asyncio.create_task(history.add(make_goal(0, GoalStatus.PENDING)))
        await until(lambda: not look(history) and history.stats().spooled > 0)
        await adding
    assert None not in reasons
    said = ("has been running for", "Connect call failed", "no connection within", "no answer")
    assert any(each in str(reasons) for each in said), reasons


def test_a_timeout_is_a_sentence_and_no_name_of_an_error() -> None:
    assert brief(TimeoutError()) == "no answer in time"
    assert brief(TimeoutError("no connection within 2 s")) == "no connection within 2 s"


async def test_a_history_that_is_slow_or_not_open_says_why(sqlite_url: str, tmp_path: Path) -> None:
    history = history_at(sqlite_url, tmp_path)
    before = history.stats()
    assert (before.database_reachable, before.last_error) == (False, "the database has not been used yet")
    await history.open()
    await until(lambda: history.stats().database_reachable)
    assert history.stats().last_error is None
    with locked(sqlite_url.removeprefix("sqlite:///")):
        await history.add(make_goal(1))
        slow = history.stats()
    assert not slow.database_reachable
    assert (slow.last_error or "").startswith("no answer within 100 ms")
    await written(history)
    assert (history.stats().database_reachable, history.stats().last_error) == (True, None)
    await history.close()


async def test_goals_go_on_and_arrive_later(
    outage: tuple[str, Outage], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    url, not_answering = outage
    async with open_at(url, tmp_path) as history:
        await history.add(make_goal(0, GoalStatus.PENDING))
        async with happening(not_answering):
            assert await timed(history.add(make_goal(1, GoalStatus.PENDING), "key-1")) < QUICK
            await until(lambda: not history.stats().database_reachable)
            monkeypatch.setattr(writer, "ANSWER_TIMEOUT", 2 * QUICK)
            times = [await timed(history.add(make_goal(number, GoalStatus.PENDING))) for number in range(2, 12)]
            assert min(times) < QUICK, "what is known to be away is not waited for"
            history.record(make_goal(1, GoalStatus.EXECUTING))
            history.record_event(make_event(1))
            history.record_event(make_event(2, droppable=True))
            await until(lambda: history.stats().spooled >= 14)
            stats = history.stats()
            assert stats.waiting >= 13
            assert stats.last_error
            goal = await history.get("goal-0001")
            assert goal is not None
            assert goal.status is GoalStatus.EXECUTING
            assert (await history.by_key("key-1") or goal).goal_id == "goal-0001"
            assert len(await history.unfinished()) >= 11
            assert await timed(history.claim("key-2", "g2", "f")) < QUICK
            with pytest.raises(Unavailable):
                await history.release("key-2", "g2")
            assert await history.claim("key-2", "g3", "f") == ("g2", "f")
        await written(history)
        assert history.stats().database_reachable
        assert history.stats().last_error is None
        assert len(await pages(history)) == 12
        assert list((tmp_path / "spool").iterdir()) == []
    async with open_at(url, tmp_path) as history:
        assert len(await history.unfinished()) == 12
        assert (await history.by_key("key-1") or goal).status is GoalStatus.EXECUTING


async def pages(history: History) -> list[Goal]:
    """All goals, as soon as the database is read again."""
    for _ in range(100):
        try:
            return await history.page(GoalFilter(), limit=10_000)
        except Unavailable:
            await asyncio.sleep(0.1)
    raise AssertionError("the database is not read again")


async def test_across_a_restart(outage: tuple[str, Outage], tmp_path: Path) -> None:
    url, not_answering = outage
    async with open_at(url, tmp_path):
        pass
    async with happening(not_answering):
        async with open_at(url, tmp_path) as history:
            await history.add(make_goal(1, GoalStatus.PENDING), "key-1")
            history.record(make_goal(2, GoalStatus.EXECUTING))
            history.record_event(make_event(1))
            start = time.perf_counter()
        assert time.perf_counter() - start < QUICK
        start = time.perf_counter()
        async with open_at(url, tmp_path) as history:
            assert time.perf_counter() - start < QUICK
            assert [goal.goal_id for goal in await history.unfinished()] == ["goal-0001", "goal-0002"]
            with pytest.raises(Unavailable):
                await history.unfinished(complete=True)
            assert await history.claim("key-1", "g2", "f") != ("g2", "f")
    async with open_at(url, tmp_path) as history:
        await written(history)
        assert len(await pages(history)) == 2
        later = await history.events_after(
            make_event(1).id or "", goal_id=None, action_name=None, topics=EVERYTHING, limit=10
        )
        assert later.events == []
        assert later.complete


async def test_what_cannot_be_looked_up_is_not_said_to_be_missing(
    postgresql_url: str, postgresql_server: PostgreSQL, tmp_path: Path
) -> None:
    async with open_at(postgresql_url, tmp_path) as history:
        await history.add(make_goal(1))
        with stopped(postgresql_server):
            for _ in range(2):
                with pytest.raises(Unavailable, match=BARRED):
                    await history.get("goal-0001")
            with pytest.raises(Unavailable, match=BARRED):
                await history.page(GoalFilter(), limit=1)
        await until(lambda: history.stats().database_reachable)
        assert len(await pages(history)) == 1


@pytest.mark.parametrize("text", ["\0", "\ud800"])
async def test_a_text_that_the_database_refuses_is_no_outage(postgresql_url: str, tmp_path: Path, text: str) -> None:
    async with open_at(postgresql_url, tmp_path) as history:
        await history.add(make_goal(1))
        with pytest.raises(Unavailable):
            await history.notes.read([text])
        with pytest.raises(Unavailable):
            await history.notes.replace_tags("goal-0001", [text])
        await history.claim(text, "goal-0002", "f")
        assert history.stats().database_reachable
        assert await history.get("goal-0001") is not None


async def test_memory_is_bounded_and_drops_nothing_that_must_be_kept(
    outage: tuple[str, Outage], tmp_path: Path
) -> None:
    url, not_answering = outage
    async with open_at(url, tmp_path, max_waiting=100) as history:
        history.record_event(make_event(0))
        await written(history)
        async with happening(not_answering):
            for number in range(1, 1001):
                history.record_event(make_event(number, droppable=number % 2 == 0))
                history.record(make_goal(number))
            assert history.stats().dropped == 400
            await until(lambda: history.stats().waiting <= 300)
            assert history.stats().spooled >= 1500
            with pytest.raises(Unavailable):
                await history.page(GoalFilter(), limit=1)
        await written(history, 30)
        assert len(await pages(history)) == 1000
        after = {"goal_id": None, "action_name": None, "topics": EVERYTHING, "limit": 10_000}
        assert not (await history.events_after(make_event(0).id or "", **after)).complete  # type: ignore[arg-type]
        later = await history.events_after(make_event(801).id or "", **after)  # type: ignore[arg-type]
        assert later.complete
        assert later.events == [make_event(number, droppable=number % 2 == 0) for number in range(802, 1001)]
        counted = sa.text("SELECT count(*) FROM events WHERE NOT droppable")
        count = await history.database.read(lambda connection: connection.scalar(counted))
        assert count == 501


class Gate:
    """No write of goals and events is carried out while it is closed."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.open = threading.Event()
        self._write = queries.write
        monkeypatch.setattr(queries, "write", self)

    def __call__(self, connection: sa.Connection, batch: Any) -> Any:
        while not self.open.is_set():
            if connection.dialect.name == "sqlite":  # in a thread
                self.open.wait()
            else:  # in the loop, which goes on while the database is busy
                connection.execute(sa.text("SELECT pg_sleep(0.05)"))
        return self._write(connection, batch)


def slowly(
    work: Callable[[sa.Connection, Any], Any], connection: sa.Connection, what: Any, seconds: float = 1.5
) -> Any:
    if connection.dialect.name == "sqlite":
        time.sleep(seconds)
    else:
        connection.execute(sa.text(f"SELECT pg_sleep({seconds})"))
    return work(connection, what)


async def test_a_slow_database_delays_nobody(
    database_url: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with open_at(database_url, tmp_path, max_waiting=5000) as history:
        gate = Gate(monkeypatch)
        for number in range(3):
            gate.open.clear()
            await history.add(make_goal(number))
            for feedback in range(500):
                history.record_event(make_event(1000 * number + feedback, droppable=True))
            gate.open.set()
            assert len(await pages(history)) == number + 1
        await written(history)
        assert history.stats().dropped == 0
        assert history.stats().database_reachable


async def test_the_spool_is_emptied_while_goals_keep_coming(
    database_url: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def submit() -> None:
        for number in itertools.count():
            await history.add(make_goal(number))
            await asyncio.sleep(0.01)

    async with open_at(database_url, tmp_path, max_waiting=5000) as history:
        monkeypatch.setattr(queries, "write", partial(slowly, queries.write, seconds=0.2))
        submitting = asyncio.create_task(submit())
        await until(lambda: history.stats().spooled >= 10)
        files = list((tmp_path / "spool").glob("*.jsonl"))
        await until(lambda: not any(file.exists() for file in files))
        await cancel(submitting)
        await written(history)
        assert history.stats().spooled == 0


async def test_no_list_is_short_while_the_spool_is_read_back(
    database_url: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise OSError("away")

    async with open_at(database_url, tmp_path, max_waiting=10) as history:
        with monkeypatch.context() as patch:
            patch.setattr(queries, "write", fail)
            for number in range(500):
                history.record(make_goal(number))
            await until(lambda: history.stats().waiting == 10)
            with pytest.raises(Unavailable, match="catching up"):
                await history.unfinished(complete=True)
        monkeypatch.setattr(queries, "write", partial(slowly, queries.write, seconds=0.3))
        assert len(await pages(history)) == 500


async def test_a_full_database(sqlite_url: str, tmp_path: Path) -> None:
    async with open_at(sqlite_url, tmp_path) as history:
        await history.add(make_goal(0))
        database = history.database
        assert isinstance(database, SqliteDatabase)
        pages_allowed = 1

        def limit(connection: sa.Connection) -> None:
            connection.exec_driver_sql(f"PRAGMA max_page_count={pages_allowed}")

        sa.event.listen(database._writer, "begin", limit)  # noqa: SLF001 - only SQLite can say that it is full
        big = b'"%s"' % (b"x" * 20_000)
        for number in range(1, 20):
            assert await timed(history.add(make_goal(number, result=big))) < QUICK
        await until(lambda: "full" in (history.stats().last_error or ""))
        assert len(await pages(history)) == 20
        pages_allowed = 100_000
        await written(history)
        assert len(await pages(history)) == 20


async def test_a_goal_that_nothing_takes_is_refused(sqlite_url: str, tmp_path: Path) -> None:
    async with open_at(sqlite_url, tmp_path):
        pass
    (tmp_path / "spool").touch()
    with locked(f"{tmp_path}/history.db"):
        history = history_at(sqlite_url, tmp_path, max_waiting=10)
        await history.open()
        with pytest.raises(Unavailable, match="must not run"):
            await history.add(make_goal(1))
    await until(lambda: history.stats().database_reachable)
    assert await history.get("goal-0001") is None
    await history.close()


async def test_a_deleted_spool_is_written_again(sqlite_url: str, tmp_path: Path) -> None:
    async with open_at(sqlite_url, tmp_path):
        pass
    folder = tmp_path / "spool"
    with locked(f"{tmp_path}/history.db"):
        async with open_at(sqlite_url, tmp_path) as history:
            await history.add(make_goal(1, GoalStatus.PENDING), "key")
            history.record_event(make_event(1))
            await until(lambda: history.stats().spooled >= 3)
            shutil.rmtree(folder)
            await history.add(make_goal(2, GoalStatus.PENDING))
            await until(lambda: history.stats().spooled >= 4)
            kept = b"".join(path.read_bytes() for path in folder.glob("*.jsonl"))
            assert all(
                name in kept for name in (b"goal-0001", b"goal-0002", b'"key"', (make_event(1).id or "").encode())
            )


async def test_the_spool_stays_while_a_goal_is_held_back(sqlite_url: str, tmp_path: Path) -> None:
    """Its events are being stored, so it is not in the database yet: the spool alone would survive a kill."""
    async with open_at(sqlite_url, tmp_path) as history:
        goal = make_goal(1, GoalStatus.EXECUTING)
        history.waiting.hold(goal.goal_id)
        await history.spool.append([goal])
        history.waiting.put_goal(goal, safe=True)
        await history.writer.flush()
        assert history.stats().spooled == 1
        assert list((tmp_path / "spool").iterdir()) != []
        history.waiting.let_go(goal.goal_id)
        await history.writer.flush()
        assert history.stats().spooled == 0
        assert await history.database.read(lambda db: db.scalar(sa.text("SELECT count(*) FROM goals"))) == 1
