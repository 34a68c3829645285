"""Goals in memory: bounded, and running ones are never forgotten.

What a history in memory has in common with databases is in test_goal_filter.py and test_goal_events.py.
"""

from datetime import UTC, datetime, timedelta

from dock_gateway.core.event import Event
from dock_gateway.core.goal import Goal, GoalStatus
from dock_gateway.storage import MemoryHistory
from tests.support.history import page_of

NOW = datetime(2026, 11, 21, tzinfo=UTC)


def make(number: int, status: GoalStatus = GoalStatus.SUCCEEDED, action: str = "/dock") -> Goal:
    return Goal(f"goal-{number}", action, "t", NOW + timedelta(seconds=number), status=status)


async def fill(history: MemoryHistory, *goals: Goal) -> None:
    for goal in goals:
        await history.add(goal)


async def ids(history: MemoryHistory, **query: object) -> list[str]:
    return [goal.goal_id for goal in await page_of(history, action_names={"/dock"}, **query)]


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
    found = await history.by_key("key")
    assert found is not goal
    assert found is not None
    assert found.document() == goal.document()
    assert await history.by_key("other") is None
    history.record(make(2))
    history.record(goal)
    assert await ids(history) == ["goal-2", "goal-1"]
    assert await history.get("goal-3") is None


async def test_the_first_claim_of_a_key_holds() -> None:
    history = MemoryHistory(10)
    assert await history.claim("key", "goal-1", "print-1") == ("goal-1", "print-1")
    assert await history.claim("key", "goal-2", "print-2") == ("goal-1", "print-1")


async def test_a_key_is_let_go_of_by_its_goal() -> None:
    history = MemoryHistory(10)
    await history.claim("key", "goal-1", "print-1")
    await history.release("key", "goal-2")
    assert await history.claim("key", "goal-2", "print-2") == ("goal-1", "print-1")
    await history.release("key", "goal-1")
    await history.release("key", "goal-1")
    assert await history.claim("key", "goal-2", "print-2") == ("goal-2", "print-2")


async def test_goals_are_kept_as_they_stood() -> None:
    history = MemoryHistory(10)
    goal = make(1, GoalStatus.EXECUTING)
    history.record(goal)
    goal.status = GoalStatus.SUCCEEDED
    assert [each.status for each in await history.unfinished()] == [GoalStatus.EXECUTING]
    history.record(goal)
    assert await history.unfinished() == []


def event(number: int, topic: str = "goals", goal_id: str = "goal-1", *, droppable: bool = False) -> Event:
    return Event(b"{}", topic, goal_id, "/dock", droppable, id=f"{number:020d}-e")


async def after(history: MemoryHistory, number: int, **query: object) -> list[int] | None:
    asked = {"goal_id": None, "action_name": None, "topics": frozenset({"goals"}), "limit": 100} | query
    events = await history.events_after(f"{number:020d}-e", **asked)  # type: ignore[arg-type]
    return [int((each.id or "")[:20]) for each in events.events] if events.complete else None


async def test_feedback_is_forgotten_before_status_and_the_gap_is_told() -> None:
    history = MemoryHistory(10, event_limit=3)
    for each in (event(1), event(2, droppable=True), event(3), event(4, "battery", droppable=True)):
        history.record_event(each)
    assert await after(history, 1) is None
    assert await after(history, 1, topics=frozenset({"battery"})) == [4]
    assert await after(history, 3) == []
    assert history.stats().dropped == 1
