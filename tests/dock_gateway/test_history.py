"""Goals in memory: newest first, in pages, bounded, and running ones are never forgotten."""

from datetime import UTC, datetime, timedelta

from dock_gateway.goals import Goal, GoalStatus
from dock_gateway.history import MemoryHistory

NOW = datetime(2026, 11, 21, tzinfo=UTC)


def make(number: int, status: GoalStatus = GoalStatus.SUCCEEDED, action: str = "/dock") -> Goal:
    return Goal(f"goal-{number}", action, "t", NOW + timedelta(seconds=number), status=status)


async def fill(history: MemoryHistory, *goals: Goal) -> None:
    for goal in goals:
        await history.add(goal)


async def ids(history: MemoryHistory, **query: object) -> list[str]:
    asked = {"action_name": "/dock", "statuses": (), "limit": 10, "before": None} | query
    return [goal.goal_id for goal in await history.page(**asked)]  # type: ignore[arg-type]


async def test_pages_are_newest_first() -> None:
    history = MemoryHistory(100)
    await fill(history, *(make(number) for number in range(5)), make(9, action="/fibonacci"))
    assert await ids(history, limit=2) == ["goal-4", "goal-3"]
    assert await ids(history, limit=2, before="goal-3") == ["goal-2", "goal-1"]
    assert await ids(history, before="goal-0") == []
    assert await ids(history, before="unknown") == []


async def test_states_are_filtered() -> None:
    history = MemoryHistory(100)
    await fill(history, make(1), make(2, GoalStatus.EXECUTING), make(3))
    assert await ids(history, statuses={GoalStatus.EXECUTING}) == ["goal-2"]


async def test_the_oldest_ended_goal_is_forgotten_first() -> None:
    history = MemoryHistory(2)
    await fill(history, make(1, GoalStatus.EXECUTING))
    await history.add(make(2), "key-2")
    await fill(history, make(3), make(4))
    assert await ids(history) == ["goal-4", "goal-1"]
    assert await history.by_key("key-2") is None


async def test_keys_and_goals_of_others() -> None:
    history = MemoryHistory(10)
    goal = make(1)
    await history.add(goal, "key")
    assert await history.by_key("key") is goal
    assert await history.by_key("other") is None
    history.record(make(2))
    history.record(goal)
    assert await ids(history) == ["goal-2", "goal-1"]
    assert await history.get("goal-3") is None
