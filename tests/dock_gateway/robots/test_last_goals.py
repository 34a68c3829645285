"""How goals ended: before the gateway began and since."""

import asyncio
from collections.abc import AsyncIterator
from datetime import UTC, datetime, timedelta

import pytest

from dock_gateway.core.cursor import Cursor
from dock_gateway.core.errors import Unavailable
from dock_gateway.core.goal import Goal, GoalStatus
from dock_gateway.robots.last_goals import READ, LastGoals, latest
from dock_gateway.storage import GoalFilter
from tests.support.history import HistoryInMemory

NOON = datetime(2026, 1, 1, 12, tzinfo=UTC)
DOCK, UNDOCK = "/dock", "/undock"


def ended(name: str, minute: int, status: GoalStatus = GoalStatus.SUCCEEDED, *, took: int = 0) -> Goal:
    """A goal that was sent at a minute past noon and took so many minutes."""
    goal = Goal(f"{name}-{minute}", name, "pkg/action/Dock", NOON + timedelta(minutes=minute))
    goal.advance(status, goal.created_at + timedelta(minutes=took))
    return goal


class AwayHistory(HistoryInMemory):
    """Does not answer until the test lets it."""

    away = True

    async def page(self, wanted: GoalFilter, *, limit: int, before: Cursor | None = None) -> list[Goal]:
        if self.away:
            raise Unavailable("away", code="history_unavailable")
        return await super().page(wanted, limit=limit, before=before)


@pytest.fixture
def history() -> AwayHistory:
    return AwayHistory()


@pytest.fixture
async def last_goals(history: AwayHistory) -> AsyncIterator[LastGoals]:
    last_goals = LastGoals(history, retry_interval=0.01)
    last_goals.watch(DOCK, UNDOCK)
    yield last_goals
    await last_goals.close()


async def until_last(last_goals: LastGoals, goal_id: str) -> None:
    for _ in range(200):
        if (last := last_goals.last(DOCK, UNDOCK)) is not None and last.goal_id == goal_id:
            return
        await asyncio.sleep(0.01)
    raise AssertionError(f"the last one is {last_goals.last(DOCK, UNDOCK)}")


async def test_what_ended_before_is_in_the_history_once_that_answers(
    history: AwayHistory, last_goals: LastGoals
) -> None:
    history.record(ended(DOCK, 1))
    for minute in range(5, 5 + READ):
        history.record(ended(DOCK, minute, GoalStatus.ABORTED))
    history.record(ended(UNDOCK, 2, GoalStatus.CANCELED))
    await asyncio.sleep(0.02)
    assert last_goals.last(DOCK, UNDOCK) is None
    history.away = False
    await until_last(last_goals, "/dock-14")
    succeeded = last_goals.succeeded(DOCK, UNDOCK)
    assert succeeded is not None
    assert succeeded.goal_id == "/dock-1"


async def test_what_ends_meanwhile_counts(history: AwayHistory, last_goals: LastGoals) -> None:
    last_goals.take(ended(DOCK, 3))
    last_goals.take(ended(UNDOCK, 4, GoalStatus.ABORTED))
    last_goals.take(ended("/fibonacci", 5))
    last, succeeded = last_goals.last(DOCK, UNDOCK), last_goals.succeeded(DOCK, UNDOCK)
    assert last is not None
    assert succeeded is not None
    assert (last.goal_id, succeeded.goal_id) == ("/undock-4", "/dock-3")
    assert last_goals.last("/fibonacci") is None
    history.record(ended(DOCK, 1))
    history.away = False
    await asyncio.sleep(0.05)
    assert last_goals.last(DOCK) is not last
    assert last_goals.last(DOCK, UNDOCK) is last


async def test_a_server_that_tells_of_an_old_goal_again_changes_nothing(
    history: AwayHistory, last_goals: LastGoals
) -> None:
    history.record(ended(DOCK, 1))
    history.record(ended(DOCK, 2, GoalStatus.REJECTED))
    history.away = False
    await until_last(last_goals, "/dock-2")
    last_goals.take(ended(DOCK, 1, took=60))
    await until_last(last_goals, "/dock-2")


def test_a_rejected_goal_counts_unless_another_one_ran_on() -> None:
    ran, rejected = ended(DOCK, 1, took=10), ended(DOCK, 5, GoalStatus.REJECTED)
    assert latest([ran, rejected]) is latest([rejected, ran]) is ran
    later = ended(DOCK, 12, GoalStatus.REJECTED)
    assert latest([ran, later]) is latest([later, ran]) is later
    assert latest([None]) is None


async def test_a_rejected_goal_did_not_run(history: AwayHistory, last_goals: LastGoals) -> None:
    history.away = False
    await asyncio.sleep(0.1)
    last_goals.take(ended(DOCK, 1, GoalStatus.ABORTED))
    last_goals.take(ended(DOCK, 2, GoalStatus.REJECTED))
    last, ran = last_goals.last(DOCK, UNDOCK), last_goals.ran(DOCK, UNDOCK)
    assert last is not None
    assert ran is not None
    assert (last.status, ran.status) == (GoalStatus.REJECTED, GoalStatus.ABORTED)
    assert last_goals.ran(UNDOCK) is None
