"""The tables come into being, once, whoever else is at it, and are those of `tables.py`."""

import asyncio
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import pytest
import sqlalchemy as sa
from alembic import command
from alembic.autogenerate import compare_metadata
from alembic.config import Config
from alembic.migration import MigrationContext

from dock_gateway.core.goal import Goal
from dock_gateway.storage.migrate import MIGRATIONS, migrate
from dock_gateway.storage.rows import goal_row
from dock_gateway.storage.sql import open_database
from dock_gateway.storage.tables import goals, metadata, prepare_for
from tests.support.history import make_goal, open_at

T = TypeVar("T")

PROGRAM = [sys.executable, "-m", "tests.support.history"]


async def carry_out(url: str, work: Callable[[sa.Connection], T]) -> T:
    """A transaction in a database that nobody has made tables in."""
    if url.startswith("sqlite"):
        prepare_for("sqlite")
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


def upgrade_to(connection: sa.Connection, revision: str) -> None:
    """Make the tables of an earlier version."""
    config = Config()
    config.set_main_option("script_location", str(MIGRATIONS))
    config.attributes["connection"] = connection
    command.upgrade(config, revision)


def insert(connection: sa.Connection, goal: Goal, *, without: tuple[str, ...]) -> None:
    """Insert a goal as an earlier version did that lacks these columns."""
    row = {name: value for name, value in goal_row(goal).items() if name not in without}
    connection.execute(sa.insert(goals).values(row))


async def test_migrations_make_the_tables_that_the_code_expects(database_url: str) -> None:
    def differences(connection: sa.Connection) -> list[Any]:
        migrate(connection)
        return compare_metadata(MigrationContext.configure(connection), metadata)

    assert await carry_out(database_url, differences) == []


async def test_goals_of_the_first_version_are_still_there(database_url: str, tmp_path: Path) -> None:
    def make_first_tables(connection: sa.Connection) -> None:
        upgrade_to(connection, "0001")
        insert(connection, make_goal(1), without=("stage", "retries", "verb"))

    await carry_out(database_url, make_first_tables)
    async with open_at(database_url, tmp_path) as history:
        goal = await history.get("goal-0001")
        assert goal is not None
        assert (goal.goal, goal.stage, goal.retries) == (b'{"order":5}', None, None)


async def test_earlier_goals_get_their_verb_from_their_type(database_url: str, tmp_path: Path) -> None:
    types = {"ConnectToChargingDock": "dock", "DisconnectFromChargingDock": "undock", "Fibonacci": None}

    def make_tables(connection: sa.Connection) -> None:
        upgrade_to(connection, "0012")
        for number, name in enumerate(types):
            goal = make_goal(number, action_type=f"action_tutorials_interfaces/action/{name}")
            insert(connection, goal, without=("verb",))

    await carry_out(database_url, make_tables)
    async with open_at(database_url, tmp_path) as history:
        goals = await history.known([f"goal-{number:04d}" for number in range(len(types))])
        assert [goal.verb for _, goal in sorted(goals.items())] == [*types.values()]


async def test_a_goal_of_the_tutorials_type_on_another_action_has_no_verb(database_url: str, tmp_path: Path) -> None:
    other = make_goal(1, action_type="action_tutorials_interfaces/action/ConnectToChargingDock")
    async with open_at(database_url, tmp_path) as history:
        await history.add(other)
    async with open_at(database_url, tmp_path) as history:
        assert (await history.known([other.goal_id]))[other.goal_id].verb is None


async def test_an_older_gateway_goes_on_with_its_goals(database_url: str, tmp_path: Path) -> None:
    """In a rolling upgrade it writes no verb, to tables that have one."""
    async with open_at(database_url, tmp_path) as history:
        await history._database.write(lambda connection: insert(connection, make_goal(1), without=("verb",)))
        goal = await history.get("goal-0001")
        assert goal is not None
        assert goal.verb is None
        goal.verb = "dock"
        await history.add(goal)
        assert (await history.known(["goal-0001"]))["goal-0001"].verb == "dock"


async def test_replicas_start_at_the_same_time(database_url: str, tmp_path: Path) -> None:
    """Processes that find no tables, and claim the same key: one makes the tables, and one gets the key."""

    async def claim(name: str) -> list[str]:
        process = await asyncio.create_subprocess_exec(
            *PROGRAM, "claim", database_url, str(tmp_path), "key", name, stdout=subprocess.PIPE
        )
        output, _ = await asyncio.wait_for(process.communicate(), 30)
        return output.decode().split()

    answers = await asyncio.gather(*(claim(f"g{number}") for number in range(3)))
    assert {answer[2] for answer in answers} == {"True"}, "each of them reached the database"
    assert len({answer[0] for answer in answers}) == 1, answers


async def test_the_tables_of_a_newer_version_are_left_alone(
    database_url: str, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    newer = sa.text("UPDATE alembic_version SET version_num = '9999'")
    async with open_at(database_url, tmp_path) as history:
        await history._database.write(lambda connection: connection.execute(newer) and None)
    async with open_at(database_url, tmp_path) as history:
        await history.add(make_goal(1))
        stats = history.stats()
        assert not stats.database_reachable
        assert stats.spooled == 1
        assert "another version of the gateway" in (stats.last_error or "")
        assert await history.get("goal-0001") is not None
    assert "another version of the gateway" in caplog.text
