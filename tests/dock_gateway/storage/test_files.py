"""The SQLite file deleted, replaced or damaged, at the start and while it is open: a new one is begun, and said so."""

import asyncio
import shutil
import sqlite3
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pytest

from dock_gateway.core.errors import Unavailable
from dock_gateway.core.goal import GoalStatus
from dock_gateway.storage import History
from dock_gateway.storage import files as damage
from tests.support.history import EVERYTHING, make_event, make_goal, open_at, timed, written
from tests.support.waiting import until

QUICK = 5.0


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "history.db"


def beside(path: Path) -> list[str]:
    """What has been set aside, without the files that belong to it."""
    return [each.name for each in path.parent.glob("*.corrupt-*") if each.name.endswith("Z")]


def goals_in(path: Path) -> list[str]:
    """What another program reads in the file."""
    with closing(sqlite3.connect(f"file:{path}?mode=ro", uri=True)) as connection:
        assert connection.execute("PRAGMA integrity_check").fetchone() == ("ok",)
        return [row[0] for row in connection.execute("SELECT goal_id FROM goals ORDER BY 1")]


async def reopened(history: History) -> None:
    """Wait until something has happened to the file and a new one is in use."""
    await until(lambda: history.incident is not None and history.stats().database_reachable)
    await written(history)
    await readable(history)


async def readable(history: History) -> None:
    for _ in range(100):
        try:
            await history.get("any")
        except Unavailable:
            await asyncio.sleep(0.1)
        else:
            return
    raise AssertionError("it is not read again")


def delete_all(path: Path) -> None:
    for each in (path, damage.beside(path, "-wal"), damage.beside(path, "-shm")):
        each.unlink()


def delete_folder(path: Path) -> None:
    shutil.rmtree(path.parent)


@pytest.mark.parametrize("delete", [Path.unlink, delete_all, delete_folder], ids=["file", "all", "folder"])
async def test_a_deleted_file_is_begun_anew(delete: Callable[[Path], None], tmp_path: Path) -> None:
    path = tmp_path / "data" / "history.db"
    running = make_goal(3, GoalStatus.EXECUTING)
    async with open_at(f"sqlite:///{path}", tmp_path) as history:
        history.on_loss.append(lambda: history.record(running))
        await history.add(make_goal(1), "key")
        history.record_event(make_event(1))
        await written(history)
        delete(path)
        assert await timed(history.add(make_goal(2))) < QUICK
        history.record_event(make_event(2))
        await reopened(history)
        stats = history.stats()
        assert (stats.database_reachable, stats.spooled) == (True, 0)
        assert f"{path} was deleted" in (stats.last_error or "")
        assert await history.get("goal-0001") is None
        assert (await history.claim("key", "another", "f"))[0] == "goal-0001", "it was sent, and must not be sent again"
        after = {"goal_id": None, "action_name": None, "topics": EVERYTHING, "limit": 10}
        later = await history.events_after(make_event(1).id or "", **after)  # type: ignore[arg-type]
        assert not later.complete
        assert not await history.knows_all_of(make_goal(3, feedback_count=1, last_event_id=make_event(1).id))
        assert goals_in(path) == ["goal-0002", "goal-0003"]
    assert goals_in(path) == ["goal-0002", "goal-0003"]
    async with open_at(f"sqlite:///{path}", tmp_path) as history:
        assert history.incident is None
        assert (await history.claim("key", "another", "f"))[0] == "goal-0001"


async def test_it_is_noticed_while_nothing_is_written(path: Path, tmp_path: Path) -> None:
    async with open_at(f"sqlite:///{path}", tmp_path) as history:
        await history.add(make_goal(1))
        await written(history)
        delete_all(path)
        await reopened(history)
        assert goals_in(path) == []


@pytest.mark.parametrize("log_stays", [True, False], ids=["its log stays", "its log is gone"])
async def test_a_replaced_file_is_used_as_it_is(path: Path, tmp_path: Path, log_stays: bool) -> None:
    other = tmp_path / "other.db"
    async with open_at(f"sqlite:///{other}", tmp_path / "other") as history:
        for number in range(300):
            history.record(make_goal(5000 + number))
        await written(history)
    async with open_at(f"sqlite:///{path}", tmp_path) as history:
        for number in range(1, 100):
            await history.add(make_goal(number))
        await written(history)
        if not log_stays:
            delete_all(path)
        other.replace(path)
        await history.add(make_goal(200))
        await reopened(history)
        assert "was replaced" in (history.stats().last_error or "")
        expected = ["goal-0200", *(f"goal-{5000 + number}" for number in range(300))]
        assert goals_in(path) == expected
    assert goals_in(path) == expected


async def test_a_deleted_log_costs_nothing(path: Path, tmp_path: Path) -> None:
    async with open_at(f"sqlite:///{path}", tmp_path) as history:
        for number in range(20):
            await history.add(make_goal(number))
        for suffix in damage.LOG_FILES:
            damage.beside(path, suffix).unlink()
            await history.add(make_goal(100))
        await written(history)
        await readable(history)
        assert history.incident is None
        assert len(goals_in(path)) == 21
    assert len(goals_in(path)) == 21


def content(path: Path) -> bytes:
    return path.read_bytes()


def garbage(path: Path) -> None:
    path.write_bytes(b"this is no database" * 1000)


def cut_off(path: Path) -> None:
    with path.open("r+b") as file:
        file.truncate(path.stat().st_size // 2)


def first_page(path: Path) -> None:
    overwrite(path, 0, 4096)


def all_but_the_first_page(path: Path) -> None:
    overwrite(path, 4096, path.stat().st_size - 4096)


def overwrite(path: Path, start: int, size: int) -> None:
    with path.open("r+b") as file:
        file.seek(start)
        file.write(b"\xa5" * size)


DAMAGE = [garbage, cut_off, first_page, all_but_the_first_page]


@pytest.mark.parametrize("damage_it", DAMAGE)
async def test_a_file_that_is_damaged_at_the_start_is_set_aside(
    damage_it: Callable[[Path], None], path: Path, tmp_path: Path
) -> None:
    async with open_at(f"sqlite:///{path}", tmp_path) as history:
        for number in range(100):
            history.record(make_goal(number))
        await written(history)
    damage_it(path)
    damaged = content(path)
    async with open_at(f"sqlite:///{path}", tmp_path) as history:
        assert await timed(history.add(make_goal(1000))) < QUICK
        await reopened(history)
        (aside,) = beside(path)
        assert aside in (history.stats().last_error or "")
        assert content(tmp_path / aside) == damaged
        assert goals_in(path) == ["goal-1000"]
    async with open_at(f"sqlite:///{path}", tmp_path) as history:
        await until(lambda: aside in (history.stats().last_error or ""))
        (tmp_path / aside).rename(tmp_path / "for the doctor")
        await until(lambda: history.stats().last_error is None)
        assert await history.get("goal-1000") is not None


@pytest.mark.parametrize("damage_it", DAMAGE)
async def test_a_file_that_is_damaged_while_it_is_open_is_set_aside(
    damage_it: Callable[[Path], None], path: Path, tmp_path: Path
) -> None:
    async with open_at(f"sqlite:///{path}", tmp_path) as history:
        for number in range(100):
            history.record(make_goal(number))
        await written(history)
    async with open_at(f"sqlite:///{path}", tmp_path) as history:
        await written(history)
        damage_it(path)
        for number in range(1000, 1100):
            await history.add(make_goal(number))
            try:
                for asked in range(100):
                    await history.get(f"goal-{asked:04d}")
            except Unavailable:
                break
        await until(lambda: history.incident is not None)
        await history.add(make_goal(2000))
        await reopened(history)
        assert len(beside(path)) == 1
        assert "damaged" in (history.stats().last_error or "")
        assert "goal-2000" in goals_in(path)
    assert "goal-2000" in goals_in(path)


def bring_into_the_file(path: Path) -> None:
    with closing(sqlite3.connect(path)) as connection:
        connection.execute("PRAGMA wal_checkpoint(TRUNCATE)")


@pytest.mark.parametrize("when", ["at the start", "while it is open"])
async def test_of_two_gateways_one_sets_it_aside(when: str, path: Path, tmp_path: Path) -> None:
    url = f"sqlite:///{path}"
    if when == "at the start":
        garbage(path)
    async with open_at(url, tmp_path / "1") as one, open_at(url, tmp_path / "2") as other:
        if when != "at the start":
            for number in range(100, 200):
                one.record(make_goal(number))
            await written(one)
            bring_into_the_file(path)
            garbage(path)
            await asyncio.gather(one.get("any"), other.get("any"), return_exceptions=True)
        await asyncio.gather(one.add(make_goal(1)), other.add(make_goal(2)))
        for history in (one, other):
            await reopened(history)
        await asyncio.gather(one.add(make_goal(3)), other.add(make_goal(4)))
        for history in (one, other):
            await written(history)
        assert len(beside(path)) == 1
        assert goals_in(path) == [f"goal-{number:04d}" for number in (1, 2, 3, 4)]


async def test_a_disk_that_damages_everything_is_not_filled(path: Path, tmp_path: Path) -> None:
    for _ in range(damage.MAX_ASIDE):
        garbage(path)
        damage.set_aside(path)
    garbage(path)
    async with open_at(f"sqlite:///{path}", tmp_path) as history:
        await history.add(make_goal(1))
        await until(lambda: "check the disk" in (history.stats().last_error or ""))
        assert len(beside(path)) == damage.MAX_ASIDE
        assert history.stats().spooled > 0
        for name in beside(path):
            (tmp_path / name).unlink()
        await written(history)
        assert goals_in(path) == ["goal-0001"]


async def test_what_only_bars_the_way_is_not_set_aside(path: Path, tmp_path: Path) -> None:
    await asyncio.to_thread(path.mkdir)
    async with open_at(f"sqlite:///{path}", tmp_path) as history:
        await history.add(make_goal(1))
        assert not history.stats().database_reachable
        assert history.incident is None
        await asyncio.to_thread(path.rmdir)
        await written(history)
        assert goals_in(path) == ["goal-0001"]
