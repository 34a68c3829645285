"""The tables come into being, once, whoever else is at it; those of another version are refused and left alone."""

import asyncio
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import pytest
import sqlalchemy as sa

from dock_gateway.storage import queries
from dock_gateway.storage.history import open_database
from dock_gateway.storage.rows import Batch
from dock_gateway.storage.schema import REVISION, create_tables
from dock_gateway.storage.tables import revisions
from tests.support.history import make_goal, open_at, written
from tests.support.waiting import PATIENCE, until

T = TypeVar("T")

OTHER_REVISIONS = ("0012", "9999")
PROGRAM = [sys.executable, "-m", "tests.support.history"]


async def make_tables_of(url: str, revision: str) -> None:
    """Make the tables of another version, with a goal."""

    def make(connection: sa.Connection) -> None:
        connection.execute(sa.update(revisions).values(version_num=revision))
        queries.write(connection, Batch(goals=[make_goal(1)]))

    database = open_database(url)
    await database.prepare()
    await database.write(make)
    await database.close()


async def carry_out(url: str, work: Callable[[sa.Connection], T]) -> T:
    """Run a transaction in a database whose tables the history may refuse."""
    if url.startswith("sqlite"):
        engine = sa.create_engine(url)
        with engine.begin() as connection:
            done = work(connection)
        engine.dispose()
        return done
    database = open_database(url)
    try:
        return await database.write(work)
    finally:
        await database.close()


def contents(connection: sa.Connection) -> tuple[str | None, list[str]]:
    """The revision and the goals of a database."""
    return connection.scalar(sa.select(revisions)), [*queries.goals_by_id(connection, ["goal-0001", "goal-0002"])]


async def test_tables_are_made_once(database_url: str) -> None:
    database = open_database(database_url)
    await database.prepare()
    await database.write(queries.write, Batch(goals=[make_goal(1)]))
    await database.write(create_tables)
    assert await database.read(contents) == (REVISION, ["goal-0001"])
    await database.close()


@pytest.mark.parametrize("revision", OTHER_REVISIONS)
async def test_the_tables_of_another_version_are_left_alone(
    revision: str, database_url: str, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    await make_tables_of(database_url, revision)
    async with open_at(database_url, tmp_path) as history:
        await history.add(make_goal(2))
        stats = history.stats()
        assert (stats.database_reachable, stats.spooled) == (False, 1)
        for said in (
            f"another version of the gateway (revision {revision}",
            "set DOCK_GATEWAY_DATABASE_URL to another",
        ):
            assert said in (stats.last_error or ""), "what to do is said in full"
            assert said in caplog.text
        assert history.incident is None
        assert await history.get("goal-0002") is not None
    assert await carry_out(database_url, contents) == (revision, ["goal-0001"])


@pytest.mark.parametrize("revision", OTHER_REVISIONS)
async def test_a_renamed_sqlite_file_makes_way_for_a_new_one(revision: str, sqlite_url: str, tmp_path: Path) -> None:
    await make_tables_of(sqlite_url, revision)
    async with open_at(sqlite_url, tmp_path) as history:
        await history.add(make_goal(2))
        (tmp_path / "history.db").rename(tmp_path / "kept.db")
        await written(history)
        await until(lambda: history.stats().database_reachable)
        assert await history.database.read(contents) == (REVISION, ["goal-0002"])
    assert await carry_out(f"sqlite:///{tmp_path}/kept.db", contents) == (revision, ["goal-0001"])


async def test_replicas_start_at_the_same_time(database_url: str, tmp_path: Path) -> None:
    """Processes that find no tables, and claim the same key: one makes the tables, and one gets the key."""

    async def claim(name: str) -> list[str]:
        process = await asyncio.create_subprocess_exec(
            *PROGRAM, "claim", database_url, str(tmp_path), "key", name, stdout=subprocess.PIPE
        )
        output, _ = await asyncio.wait_for(process.communicate(), PATIENCE)
        return output.decode().split()

    answers = await asyncio.gather(*(claim(f"g{number}") for number in range(3)))
    assert {answer[2] for answer in answers} == {"True"}, "each of them reached the database"
    assert len({answer[0] for answer in answers}) == 1, answers
