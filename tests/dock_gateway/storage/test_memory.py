"""SQLite in memory: nothing waits for it."""

import asyncio
import threading

import pytest
import sqlalchemy as sa

from dock_gateway.core.goal import Goal, GoalStatus
from dock_gateway.storage.memory import MemoryDatabase
from dock_gateway.storage.tables import documents
from tests.support.history import HistoryInMemory, make_event, make_goal
from tests.support.waiting import PATIENCE


def put(connection: sa.Connection, key: str) -> None:
    connection.execute(sa.insert(documents), {"kind": "rule", "key": key, "document": b"{}"})


def keys(connection: sa.Connection) -> list[str]:
    return list(connection.scalars(sa.select(documents.c.key).order_by(documents.c.key)))


async def test_a_transaction_that_fails_changes_nothing() -> None:
    def fail(connection: sa.Connection) -> None:
        put(connection, "b")
        raise ValueError("no")

    database = MemoryDatabase()
    await database.write(put, "a")
    with pytest.raises(ValueError, match="no"):
        await database.write(fail)
    assert await database.read(keys) == ["a"]
    await database.close()


async def test_a_large_read_holds_up_nothing_and_sees_one_moment() -> None:
    begun, go_on = threading.Event(), threading.Event()

    def read(connection: sa.Connection) -> list[str]:
        begun.set()
        assert go_on.wait(PATIENCE)
        return keys(connection)

    database = MemoryDatabase()
    await database.write(put, "a")
    reading = asyncio.create_task(database.read_much(read))
    await asyncio.to_thread(begun.wait, PATIENCE)
    await database.write(put, "b")
    go_on.set()
    assert await reading == ["a"]
    assert await database.read(keys) == ["a", "b"]


async def test_no_goal_waits_for_a_write() -> None:
    """What is not written yet is as safe as what is: both end with the process."""

    async def refuse(*_: object, **__: object) -> None:
        raise AssertionError("written")

    history = HistoryInMemory()
    history.database.write = refuse  # type: ignore[method-assign]
    goal, end = make_goal(1, GoalStatus.PENDING), make_event(1)
    await history.add(goal, "key")
    goal.status = GoalStatus.SUCCEEDED
    assert await history.seal(goal, [end]) == [end]
    kept = await history.get(goal.goal_id)
    assert isinstance(kept, Goal)
    assert kept.status is GoalStatus.SUCCEEDED
    assert kept is not goal
    found = await history.by_key("key")
    assert found is not None
    assert found.goal_id == goal.goal_id
