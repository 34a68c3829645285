"""Goals are found by their error code."""

from pathlib import Path

import sqlalchemy as sa

from dock_gateway.core.goal import GoalError, GoalStatus
from dock_gateway.storage import GoalFilter, History, queries
from dock_gateway.storage.rows import MAX_CODE
from tests.support.history import explain, make_goal, open_at, page_of, settled


async def filled(history: History, codes: list[str | None]) -> None:
    for number, code in enumerate(codes):
        error = None if code is None else GoalError(code, "why")
        history.record(make_goal(number, GoalStatus.ABORTED, goal=b"x" * 1000, error=error))
    await settled(history)


async def test_an_index_is_used(database_url: str, tmp_path: Path) -> None:
    def page(connection: sa.Connection) -> None:
        wanted = GoalFilter(error_codes=frozenset({"blocked"}))
        queries.page(connection, wanted, limit=10, before=None, without=())

    async with open_at(database_url, tmp_path, max_waiting=3000) as history:
        await filled(history, [None if number % 100 else "blocked" for number in range(2000)])
        assert "goals_by_error" in await history.database.read(explain, page)


async def test_a_long_one_is_shortened(database_url: str, tmp_path: Path) -> None:
    """PostgreSQL refuses index entries of more than 2,700 bytes, and so the goal."""
    async with open_at(database_url, tmp_path) as history:
        await filled(history, ["ö\0" * 5000])
        assert len(await page_of(history, error_codes=frozenset({"ö" * MAX_CODE}))) == 1
