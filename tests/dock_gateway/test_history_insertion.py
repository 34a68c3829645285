"""A new row in one call of SQLite: as SQLAlchemy would have stored it, once, and never in part."""

import sqlite3
from contextlib import closing
from pathlib import Path

import pytest
import sqlalchemy as sa

from dock_gateway.history import store
from dock_gateway.history.insertion import Insertion
from dock_gateway.history.rows import Batch, goal_row
from dock_gateway.history.sqlite import SqliteDatabase
from dock_gateway.history.tables import goals
from tests.support.history import make_goal


def raw(connection: sa.Connection) -> list[tuple[object, ...]]:
    return [tuple(row)[1:] for row in connection.exec_driver_sql("SELECT * FROM goals ORDER BY goal_id")]


async def test_a_row(tmp_path: Path) -> None:
    database = SqliteDatabase(tmp_path / "history.db")
    insertion = Insertion(database._single_writer, goals)
    first, second = goal_row(make_goal(1)), make_goal(2)
    with pytest.raises(sa.exc.OperationalError, match="no such table"):
        insertion.add(first)
    await database.prepare()
    assert insertion.add(first)
    assert not insertion.add(first), "it is there already"
    assert not insertion.add({**first, "goal_id": "bad", "goal": b"\xff"}), "it is not text"
    assert not insertion.add({**first, "goal_id": "bad", "status": None}), "it must have a value"
    second.created_at = second.updated_at = make_goal(1).created_at
    await database.write(store.write, Batch(goals=[second]))
    quick, thorough = await database.read(raw)
    assert quick == thorough
    insertion.close()
    assert insertion.add(goal_row(make_goal(3)))
    with closing(sqlite3.connect(tmp_path / "history.db", isolation_level=None)) as other:
        other.execute("BEGIN IMMEDIATE")
        with pytest.raises(sa.exc.OperationalError, match="locked"):
            insertion.add(goal_row(make_goal(4)))
    assert insertion.add(goal_row(make_goal(4)))
    insertion.close()
    await database.close()
