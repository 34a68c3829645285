"""What all gateways of a user shared once is taken over by the first one that starts, and not from a living one."""

import asyncio
import shutil
import sqlite3
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import pytest

from dock_gateway.settings import Settings
from dock_gateway.storage import History, open_history
from dock_gateway.storage.handover import take_over_database
from dock_gateway.storage.spool import Spool
from tests.support.history import make_goal, open_at, written


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """The user's data directory."""
    return tmp_path / "data" / "dock-gateway"


@pytest.fixture
def shared(folder: Path) -> str:
    """The database that all gateways of the user had."""
    return f"sqlite:///{folder}/history.db"


@asynccontextmanager
async def gateway_of(domain: int) -> AsyncIterator[History]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ROS_DOMAIN_ID", str(domain))
        async with open_history(Settings()) as history:
            yield history


def names(folder: Path, pattern: str) -> list[str]:
    return sorted(path.name for path in folder.glob(pattern))


async def knows(history: History, number: int) -> bool:
    return await history.get(f"goal-{number:04d}") is not None


async def test_the_first_gateway_takes_what_there_was(folder: Path, shared: str) -> None:
    async with open_at(shared, folder) as before:
        await before.add(make_goal(1))
    spool = Spool(folder / "spool")
    await spool.append([make_goal(2)])
    await spool.close()
    async with gateway_of(1) as first, gateway_of(2) as second:
        assert [await knows(first, number) for number in (1, 2)] == [True, True]
        assert [await knows(second, number) for number in (1, 2)] == [False, False]
    assert names(folder, "*") == ["history-1-localhost.db", "history-2-localhost.db", "spool-1-localhost"]
    async with gateway_of(1) as first:
        assert await knows(first, 1)


async def test_a_log_that_a_crash_left_is_taken_along(folder: Path, shared: str, tmp_path: Path) -> None:
    async with open_at(shared, tmp_path / "crashed") as before:
        await before.add(make_goal(1))
        shutil.copytree(folder, tmp_path / "as it was")
    shutil.rmtree(folder)
    shutil.move(tmp_path / "as it was", folder)
    assert (folder / "history.db-wal").stat().st_size > 0
    async with gateway_of(1) as first:
        assert await knows(first, 1)
    assert names(folder, "history.db*") == []


async def test_from_a_running_gateway_nothing_is_taken(
    folder: Path, shared: str, caplog: pytest.LogCaptureFixture
) -> None:
    living = Spool(folder / "spool")
    await living.append([make_goal(2)])
    async with open_at(shared, folder) as running:
        await running.add(make_goal(1))
        async with gateway_of(1) as new:
            assert [await knows(new, number) for number in (1, 2)] == [False, False]
        assert "is not changed" in caplog.text
        await running.add(make_goal(3))
        await written(running)
    assert len(names(folder / "spool", "*")) == 1
    await living.close()
    async with gateway_of(1) as new:
        assert [await knows(new, number) for number in (1, 2, 3)] == [False, True, False], "it has its own already"
    async with gateway_of(2) as other:
        assert [await knows(other, number) for number in (1, 2, 3)] == [True, False, True]


async def test_of_many_that_start_one_takes_it(folder: Path, shared: str) -> None:
    async with open_at(shared, folder) as before:
        await before.add(make_goal(1))
    paths = [folder / f"history-{domain}.db" for domain in range(5)]
    await asyncio.gather(*(asyncio.to_thread(take_over_database, folder / "history.db", path) for path in paths))
    assert len(names(folder, "history*")) == 1


async def test_what_is_no_database_is_taken_over_as_it_is(folder: Path) -> None:
    await asyncio.to_thread(folder.mkdir, parents=True)
    (folder / "history.db").write_bytes(b"no database" * 1000)
    async with gateway_of(1) as history:
        await history.add(make_goal(1))
    assert len(names(folder, "*.corrupt-*")) == 1
    with sqlite3.connect(folder / "history-1-localhost.db") as connection:
        assert connection.execute("SELECT count(*) FROM goals").fetchone() == (1,)
    connection.close()
