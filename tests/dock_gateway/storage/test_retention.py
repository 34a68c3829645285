"""What is too old or too much goes: feedback and battery events, and goals that have ended with all their events."""

import asyncio
import time
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
import sqlalchemy as sa

from dock_gateway.core.event import Event, feedback_event, nanoseconds, result_event, status_event, stop_event, time_id
from dock_gateway.core.goal import Goal, GoalStatus
from dock_gateway.settings import Settings
from dock_gateway.storage import History, open_history, retention
from dock_gateway.storage.tables import events, goals, idempotency_keys
from tests.support.history import EVERYTHING, START_NS, make_event, make_goal, open_at, written
from tests.support.waiting import until

HOUR_NS = 3600 * 10**9


async def left(history: History) -> list[str]:
    return await history.database.read(lambda db: list(db.scalars(sa.select(events.c.id).order_by(events.c.id))))


async def follows(history: History, event_id: str, *topics: str) -> int | None:
    found = await history.events_after(
        event_id, goal_id=None, action_name=None, topics=frozenset(topics) or EVERYTHING, limit=10_000
    )
    return len(found.events) if found.complete else None


async def test_by_age(database_url: str, tmp_path: Path) -> None:
    now = time.time_ns() - START_NS  # minutes, after many other tests
    old = [make_event(now + number - 2 * HOUR_NS, "battery", droppable=True) for number in range(2500)]
    status = make_event(now - 3 * HOUR_NS)
    later_status = make_event(now - HOUR_NS // 2)
    new = make_event(now - HOUR_NS // 2 + 1, "battery", droppable=True)
    async with open_at(database_url, tmp_path, max_waiting=5000, event_age=3600) as history:
        history.record(make_goal(1, GoalStatus.SUCCEEDED))
        for event in [*old, status, later_status, new]:
            history.record_event(event)
        await written(history)
        assert await history.retention.enforce() == len(old)
        assert await left(history) == [status.id, later_status.id, new.id]
        assert await history.get("goal-0001") is not None
        assert await follows(history, status.id or "") is None
        assert await follows(history, status.id or "", "goals") == 1
        assert await follows(history, later_status.id or "") == 1
        assert await history.retention.enforce() == 0


async def test_by_size(database_url: str, tmp_path: Path) -> None:
    made = [make_event(number, droppable=number % 10 != 0) for number in range(1000)]
    size = len(made[1].data)
    async with open_at(database_url, tmp_path, event_bytes=100 * size) as history:
        for event in made:
            history.record_event(event)
        await written(history)
        assert await history.retention.enforce() == 800
        ids = await left(history)
        droppable = [event.id for event in made if event.droppable]
        assert ids == sorted({event.id or "" for event in made if not event.droppable} | set(droppable[-100:]))
        assert await follows(history, made[880].id or "") is None
        assert await follows(history, made[900].id or "") == 99


async def test_two_replicas_clean_up_together(database_url: str, tmp_path: Path) -> None:
    async with (
        open_at(database_url, tmp_path, event_bytes=1, max_waiting=5000) as one,
        open_at(database_url, tmp_path, event_bytes=1) as other,
    ):
        for number in range(3000):
            one.record_event(make_event(number, "battery", droppable=True))
        await written(one)
        await asyncio.gather(one.retention.enforce(), other.retention.enforce())
        assert await left(one) == []


DAY = timedelta(days=1)


def made(number: int, days: float, status: GoalStatus = GoalStatus.SUCCEEDED, heard: float | None = None) -> Goal:
    """A goal that was sent so many days ago, and `heard` of last then, too, or later."""
    sent, last = (datetime.now(UTC) - ago * DAY for ago in (days, days if heard is None else heard))
    return make_goal(number, status, created_at=sent, updated_at=last)


def story(goal: Goal, feedback: int = 0) -> list[Event]:
    """A status event, feedback and a result, all of the time when the goal was sent."""
    kinds = [status_event, *[feedback_event] * feedback, result_event]
    start = nanoseconds(goal.created_at)
    return [make(goal, start + number) for number, make in enumerate(kinds)]


async def keep(history: History, goals: list[Goal], feedback: int = 0) -> list[Event]:
    kept = [event for goal in goals for event in story(goal, feedback)]
    for goal in goals:
        history.record(goal)
    for event in kept:
        history.record_event(event)
    await written(history)
    return kept


async def goals_left(history: History) -> list[str]:
    return await history.database.read(
        lambda db: list(db.scalars(sa.select(goals.c.goal_id).order_by(goals.c.goal_id)))
    )


async def test_old_goals_go_with_all_that_there_is_of_them(database_url: str, tmp_path: Path) -> None:
    old = [made(number, 400 + number) for number in range(100)]
    lost = made(200, 400, GoalStatus.LOST)
    lost_lately = made(201, 400, GoalStatus.LOST, heard=0)
    running = [made(300 + number, 400, status) for number, status in enumerate(GoalStatus) if not status.terminal]
    new = made(400, 300)
    age = 365 * DAY.total_seconds()
    async with open_at(database_url, tmp_path, goal_age=age, max_waiting=5000) as history:
        kept = await keep(history, [*old, lost, lost_lately, *running, new], feedback=3)
        await history.add(made(500, 400), "key")
        assert await history.retention.enforce() == 101 * 5
        stay = [goal.goal_id for goal in (lost_lately, *running, new)]
        assert await goals_left(history) == [*stay, "goal-0500"], "a retry with its key must find it"
        assert await left(history) == sorted(event.id or "" for event in kept if event.goal_id in stay)
        assert await history.get("goal-0001") is None
        gone = sorted(event.id or "" for event in kept if event.goal_id not in stay)
        assert [await follows(history, event_id) for event_id in (gone[0], gone[-2])] == [None, None]
        assert await follows(history, gone[-1]) is not None
        await history.database.write(lambda db: db.execute(sa.delete(idempotency_keys)) and None)
        await history.retention.enforce()
        assert await history.get("goal-0500") is None


async def test_memory_keeps_a_number_of_goals_and_of_keys(tmp_path: Path) -> None:
    async with open_history(Settings(database_url="memory:", memory_max_goals=10)) as history:
        with_key = [made(number, 3) for number in range(2)]
        for number, goal in enumerate(with_key):
            await history.add(goal, f"key-{number}")
        running = made(9, 3, GoalStatus.EXECUTING)
        await keep(history, [running, *(made(100 + number, 2) for number in range(30))])
        await history.retention.enforce()
        newest = [f"goal-{120 + number:04d}" for number in range(10)]
        assert await goals_left(history) == ["goal-0000", "goal-0001", "goal-0009", *newest]
        await history.database.write(retention.delete_old_keys, 1)
        await history.retention.enforce()
        left_over = {number for number, key in enumerate(("key-0", "key-1")) if await history.by_key(key) is not None}
        assert len(await goals_left(history)) == 12
        assert left_over == {1}


async def test_memory_is_checked_often(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(retention, "MEMORY_INTERVAL", 0.01)
    async with open_history(Settings(database_url="memory:", feedback_retention_days=1 / 24)) as history:
        now = time.time_ns() - START_NS
        history.record_event(make_event(now - 2 * HOUR_NS, "battery", droppable=True))
        await until(lambda: not history.stats().waiting)
        for _ in range(1000):
            if not await left(history):
                return
            await asyncio.sleep(0.01)
    raise AssertionError("nothing was deleted")


async def test_the_oldest_goals_go_where_they_are_too_much(database_url: str, tmp_path: Path) -> None:
    ended = [made(number, 200 - number) for number in range(100)]
    running = made(1000, 300, GoalStatus.EXECUTING)
    size = sum(len(event.data) + retention.OVERHEAD for event in story(ended[0]))
    async with open_at(database_url, tmp_path, goal_bytes=51 * size) as history:
        await keep(history, [running, *ended], feedback=1)
        await history.retention.enforce()
        ids = await goals_left(history)
        assert ids == [goal.goal_id for goal in [*ended[-len(ids) + 1 :], running]]
        assert len(ids) == 51
        assert await history.retention.enforce() == 0


async def test_a_goal_with_more_events_than_a_transaction_takes(database_url: str, tmp_path: Path) -> None:
    limits = {"goal_age": DAY.total_seconds()}
    async with open_at(database_url, tmp_path, max_waiting=5000, **limits) as history:
        await keep(history, [made(1, 2), made(2, 2)], feedback=retention.CHUNK)
        assert await history.retention.enforce() == 2 * (retention.CHUNK + 2)
        assert await goals_left(history) == []
        assert await left(history) == []


async def test_two_replicas_delete_goals_together(database_url: str, tmp_path: Path) -> None:
    limits = {"goal_age": DAY.total_seconds()}
    async with (
        open_at(database_url, tmp_path / "1", **limits) as one,
        open_at(database_url, tmp_path / "2", **limits) as other,
    ):
        await keep(one, [made(number, 2) for number in range(200)])
        deleted = await asyncio.gather(one.retention.enforce(), other.retention.enforce())
        assert sum(deleted) == 400
        assert await goals_left(one) == []


async def test_two_replicas_delete_no_more_than_is_too_much(
    database_url: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(retention, "MOST_EVENTS", 30)
    monkeypatch.setattr(retention, "MOST_GOALS", 30)
    ended = [made(number, 200 - number) for number in range(200)]
    status, feedback, result = story(ended[0], 1)
    size = len(status.data) + len(result.data) + 2 * retention.OVERHEAD
    limits = {"goal_bytes": 100 * size, "event_bytes": 80 * len(feedback.data)}
    async with (
        open_at(database_url, tmp_path / "1", **limits) as one,
        open_at(database_url, tmp_path / "2", **limits) as other,
    ):
        await keep(one, ended, feedback=1)
        await asyncio.gather(one.retention.enforce(), other.retention.enforce())
        assert await goals_left(one) == [goal.goal_id for goal in ended[-100:]]
        assert len(await left(one)) == 2 * 100 + 80


async def test_the_longest_and_largest_that_can_be_set(database_url: str, tmp_path: Path) -> None:
    settings = Settings(
        feedback_retention_days=365_000,
        feedback_retention_mb=10**9,
        goal_retention_days=365_000,
        goal_retention_mb=10**9,
        audit_retention_days=365_000,
        database_url=database_url,
        spool_path=tmp_path / "spool",
    )
    async with open_history(settings) as history:
        kept = await keep(history, [made(1, 10_000)], feedback=1)
        assert await history.retention.enforce() == 0
        assert await left(history) == [event.id for event in kept]


async def test_stops_go_with_battery_events_though_no_slow_reader_misses_them(
    database_url: str, tmp_path: Path
) -> None:
    now = time.time_ns()
    old, new = (stop_event({"latched": True}, now - hours * HOUR_NS, robot="/") for hours in (2, 0))
    assert [event.droppable for event in (old, new)] == [False, False]
    async with open_at(database_url, tmp_path, event_age=3600) as history:
        for event in (old, new):
            history.record_event(event)
        await written(history)
        assert await history.retention.enforce() == 1
        assert await left(history) == [new.id]
        assert await follows(history, old.id or "", "stop") == 1
        assert await follows(history, time_id(now - 3 * HOUR_NS), "stop") is None
