"""Turns: the end of a goal is stored behind all that any gateway may have published, and each gateway learns of it."""

import asyncio
from pathlib import Path

import sqlalchemy as sa

from dock_gateway.core.event import NEVER, Event, result_event, status_event, time_id
from dock_gateway.core.goal import Goal, GoalStatus
from dock_gateway.storage import History
from dock_gateway.storage.order import STEP, Turn, take_turn
from dock_gateway.storage.rows import Batch
from dock_gateway.storage.tables import events
from tests.support.history import make_goal, open_at, written
from tests.support.waiting import until

S = GoalStatus


def ended(number: int, status: GoalStatus = GoalStatus.SUCCEEDED, stamp: int = 1) -> Batch:
    goal = make_goal(number, status)
    return Batch(goals=[goal], events=[status_event(goal, stamp), result_event(goal, stamp)])


async def turn(history: History, after: str | None, wanted: int = 0, batch: Batch | None = None) -> Turn:
    return await history.database.write(take_turn, batch or Batch(), after, wanted)


async def test_an_end_is_stored_behind_all_that_anyone_was_allowed(database_url: str, tmp_path: Path) -> None:
    async with open_at(database_url, tmp_path) as history:
        far = 3 * 10**18
        ours, theirs = await turn(history, None, far), await turn(history, None)
        assert ours.allowed == time_id(far) + NEVER
        assert theirs.allowed == time_id(far + STEP) + NEVER
        stored = await turn(history, ours.allowed, batch=ended(1))
        assert [event.key for event in stored.events] == ["s-goal-0001", "z-goal-0001"]
        assert [event.ends_goal for event in stored.events] == [False, True]
        assert (stored.events[0].id or "") > theirs.allowed > ours.allowed
        assert stored.allowed > (stored.events[1].id or "")
        goal = await history.get("goal-0001")
        assert goal is not None
        assert goal.last_event_id == stored.events[1].id
        again = await turn(history, theirs.allowed, batch=ended(1, GoalStatus.ABORTED))
        assert again.events == stored.events
        assert [event.id for event in again.stored.values() if event] == [event.id for event in stored.events]
        assert (await turn(history, stored.allowed)).events == []
        rejected = (await turn(history, again.allowed, batch=ended(2, GoalStatus.REJECTED))).events
        assert [event.ends_goal for event in rejected] == [False, True]


def state(number: int, status: GoalStatus, stamp: int) -> Batch:
    goal = make_goal(number, status)
    return Batch(goals=[goal], events=[status_event(goal, stamp)])


async def test_a_state_comes_once_though_gateways_notice_it_at_different_times(
    database_url: str, tmp_path: Path
) -> None:
    async with open_at(database_url, tmp_path) as history:
        begin = (await turn(history, None)).allowed

        async def put(status: GoalStatus, stamp: int) -> Event | None:
            (stored,) = (await turn(history, begin, batch=state(1, status, stamp))).stored.values()
            return stored

        kept = [await put(status, stamp) for stamp, status in enumerate((S.PENDING, S.ACCEPTED, S.EXECUTING))]
        assert await put(S.EXECUTING, 7) is None, "another message said the same"
        assert await put(S.ACCEPTED, 8) is None, "the other gateway was behind"
        kept += [await put(S.LOST, 9), await put(S.EXECUTING, 10)]
        kept += (await turn(history, begin, batch=ended(1, stamp=11))).stored.values()
        assert await put(S.LOST, 12) is None, "it has ended"
        told = (await turn(history, begin)).events
        assert [(each.id, each.key) for each in told] == [each and (each.id, each.key) for each in kept]
        assert [each.ends_goal for each in told] == [False, False, False, True, False, False, True]
        assert sorted(each.id or "" for each in told) == [each.id for each in told]


async def test_gateways_that_store_ends_at_the_same_time_learn_of_all(postgresql_url: str, tmp_path: Path) -> None:
    async with open_at(postgresql_url, tmp_path / "a") as one, open_at(postgresql_url, tmp_path / "b") as other:
        told: dict[str, list[Event]] = {"one": [], "other": []}
        asks = [
            one.follow(lambda ends, _: told["one"].extend(ends)),
            other.follow(lambda ends, _: told["other"].extend(ends)),
        ]

        async def end(number: int) -> None:
            batch = ended(number)
            for history in (one, other) if number % 2 else (other, one):
                await history.seal(batch.goals[0], batch.events)

        await asyncio.gather(*map(end, range(20)))
        for ask in asks:
            ask()
        await until(lambda: all(len(ends) == 40 for ends in told.values()))
        assert told["one"] == told["other"] == sorted(told["one"], key=lambda event: event.id or "")
        await written(one)
        assert await one.database.read(lambda db: db.scalar(sa.select(sa.func.count()).select_from(events))) == 40


async def test_a_goal_is_not_written_as_ended_before_its_end(sqlite_url: str, tmp_path: Path) -> None:
    """A gateway that is killed in between would leave a goal that nobody tells the end of."""
    async with open_at(sqlite_url, tmp_path) as history:
        goal: Goal = ended(1).goals[0]
        history.waiting.hold(goal.goal_id)
        history.record(goal)
        history.record(make_goal(2))
        await history.writer.flush()
        assert set(await history.database.read(lambda db: db.scalars(sa.text("SELECT goal_id FROM goals")).all())) == {
            "goal-0002"
        }
        found = await history.get(goal.goal_id)
        assert found is not None
        assert found.status is GoalStatus.SUCCEEDED
    async with open_at(sqlite_url, tmp_path) as history:
        assert await history.get(goal.goal_id) is not None, "written at the close"
