"""Feedback and battery events go when they are too old or too much; goals, status and results stay."""

import asyncio
from pathlib import Path

import sqlalchemy as sa

from dock_gateway.goals import GoalStatus
from dock_gateway.history.sql import SqlHistory
from dock_gateway.history.tables import events
from tests.support.history import EVERYTHING, make_event, make_goal, open_at, written

HOUR_NS = 3600 * 10**9


async def left(history: SqlHistory) -> list[str]:
    return await history._database.read(lambda db: list(db.scalars(sa.select(events.c.id).order_by(events.c.id))))


async def follows(history: SqlHistory, event_id: str, *topics: str) -> int | None:
    found = await history.events_after(
        event_id, goal_id=None, action_name=None, topics=frozenset(topics) or EVERYTHING, limit=10_000
    )
    return len(found.events) if found.complete else None


async def test_by_age(database_url: str, tmp_path: Path) -> None:
    old = [make_event(number - 2 * HOUR_NS, "battery", droppable=True) for number in range(2500)]
    status = make_event(-3 * HOUR_NS)
    later_status = make_event(-HOUR_NS // 2)
    new = make_event(-HOUR_NS // 2 + 1, "battery", droppable=True)
    async with open_at(database_url, tmp_path, max_waiting=5000) as history:
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
    async with open_at(database_url, tmp_path, max_bytes=100 * size) as history:
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
        open_at(database_url, tmp_path, max_bytes=1, max_waiting=5000) as one,
        open_at(database_url, tmp_path, max_bytes=1) as other,
    ):
        for number in range(3000):
            one.record_event(make_event(number, "battery", droppable=True))
        await written(one)
        await asyncio.gather(one.retention.enforce(), other.retention.enforce())
        assert await left(one) == []
