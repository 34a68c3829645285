"""How goals ended is counted the same in all databases, and as by hand."""

import asyncio
import statistics
from collections import Counter
from datetime import timedelta
from pathlib import Path
from typing import Any

import asyncpg
import numpy as np
import pytest
import sqlalchemy as sa
from hypothesis import given
from hypothesis import strategies as st

from dock_gateway.core.goal import Goal, GoalError, GoalStatus
from dock_gateway.extensions.statistics import tally as tallies
from dock_gateway.extensions.statistics.tally import Span, Tally, merged, tally_goals
from dock_gateway.storage import GoalFilter, History, queries
from dock_gateway.storage.memory import MemoryDatabase
from dock_gateway.storage.rows import MAX_CODE, Batch
from tests.support.history import NOW, explain, make_goal, open_at, open_place, settled

EVER = (NOW - timedelta(days=1), NOW + timedelta(days=1))
ENDS = [status for status in GoalStatus if status.terminal]


def ended(number: int, status: GoalStatus = GoalStatus.SUCCEEDED, took: float | None = 1.0, **more: Any) -> Goal:
    goal = make_goal(number, status, **more)
    goal.finished_at = None if took is None else goal.created_at + timedelta(seconds=took)
    return goal


def by_hand(goals: list[Goal], span: Span) -> dict[str, Any]:
    """The plain count of goals that ended, without any of the code under test."""
    inside = [goal for goal in goals if goal.status in ENDS and span[0] <= goal.created_at < span[1]]
    retries = [goal.retries for goal in inside if goal.retries is not None]
    took = [
        (goal.finished_at - goal.created_at).total_seconds()
        for goal in inside
        if goal.status is GoalStatus.SUCCEEDED and goal.finished_at is not None
    ]
    succeeded = sum(goal.status is GoalStatus.SUCCEEDED for goal in inside)
    canceled = sum(goal.status is GoalStatus.CANCELED for goal in inside)
    return {
        "statuses": Counter(goal.status for goal in inside),
        "errors": Counter(goal.error.code for goal in inside if goal.error is not None),
        "rate": succeeded / (len(inside) - canceled) if len(inside) > canceled else None,
        "retries": statistics.mean(retries) if retries else None,
        "median": statistics.median(took) if took else None,
    }


def seen(tally: Tally) -> dict[str, Any]:
    return {
        "statuses": tally.statuses,
        "errors": tally.errors,
        "rate": tally.success_rate,
        "retries": tally.mean_retries,
        "median": tally.percentiles(50)[0],
    }


def check(tally: Tally, goals: list[Goal], span: Span) -> None:
    expected = by_hand(goals, span)
    for name, value in seen(tally).items():
        # SQLite's times have a resolution of a millisecond.
        wanted = expected[name]
        assert value == (pytest.approx(wanted, abs=0.0021) if isinstance(wanted, float) else wanted), name


codes = st.sampled_from(["failed_to_charge", "blocked", "äöü, 'quoted'", "a,b"])
some_goals = st.builds(
    ended,
    st.integers(0, 2000),
    st.sampled_from(list(GoalStatus)),
    took=st.none() | st.floats(0, 10**5),
    action=st.sampled_from(["/dock", "/robot1/dock", "/robot1/undock"]),
    retries=st.none() | st.integers(0, 5),
    error=st.none() | st.builds(GoalError, codes, st.just("why")),
)


async def filled(history: History, goals: list[Goal]) -> None:
    for goal in goals:
        history.record(goal)
    await settled(history)


def tallied(goals: list[Goal], spans: list[Span]) -> list[tallies.Tallies]:
    database = MemoryDatabase()

    async def rows() -> Any:
        await database.write(queries.write, Batch(goals=goals))
        return await database.read(tallies.read_rows, GoalFilter(), spans, True)

    return tallies.tally_rows(asyncio.run(rows()))


@given(st.lists(some_goals, max_size=30, unique_by=lambda goal: goal.goal_id), st.integers(0, 2000))
def test_the_goals_of_any_span_are_counted_as_by_hand(goals: list[Goal], second: int) -> None:
    middle = NOW + timedelta(seconds=second)
    spans = [(EVER[0], middle), (middle, EVER[1]), (middle, middle)]
    for span, found in zip(spans, tallied(goals, spans), strict=True):
        for action, tally in found.items():
            check(tally, [goal for goal in goals if goal.action_name == action], span)
        check(merged(found.values()), goals, span)


async def test_any_goals_are_counted_as_by_hand(place: str, tmp_path: Path) -> None:
    """Hypothesis' goals, put into one history; each action holds another sample of them."""
    samples: list[list[Goal]] = []

    @given(st.lists(some_goals, min_size=5, max_size=30))
    def collect(goals: list[Goal]) -> None:
        samples.append(goals)

    collect()
    goals: list[Goal] = []
    for number, sample in enumerate(samples[-40:]):
        for place_in_sample, goal in enumerate(sample):
            goal.goal_id = f"goal-{number}-{place_in_sample}"
            goal.action_name = f"/sample{number}{goal.action_name}"
            goals.append(goal)
    goals = goals[:900]  # as many as the history in memory keeps
    async with open_place(place, tmp_path, max_waiting=2000) as history:
        await filled(history, goals)
        middle = NOW + timedelta(seconds=700)
        spans = [(EVER[0], middle), (middle, EVER[1]), EVER]
        for span, found in zip(spans, await tally_goals(history, GoalFilter(), spans, by_action=True), strict=True):
            inside = {
                goal.action_name for goal in goals if goal.status in ENDS and span[0] <= goal.created_at < span[1]
            }
            assert found.keys() == inside
            for action, tally in found.items():
                check(tally, [goal for goal in goals if goal.action_name == action], span)
            check(merged(found.values()), goals, span)
        for span, found in zip(spans, await tally_goals(history, GoalFilter(), spans, by_action=False), strict=True):
            assert found.keys() == {""}
            check(found[""], goals, span)


async def test_the_filter_applies(place: str, tmp_path: Path) -> None:
    goals = [
        ended(1, action="/robot1/dock"),
        ended(2, GoalStatus.ABORTED, action="/robot1/dock", error=GoalError("blocked", "")),
        ended(3, action="/robot2/dock", origin="external"),
        ended(4, GoalStatus.LOST, action="/robot2/undock"),
        make_goal(5, GoalStatus.EXECUTING, action="/robot2/undock"),
    ]
    async with open_place(place, tmp_path) as history:
        assert await tally_goals(history, GoalFilter(), [EVER, EVER], by_action=True) == [{}, {}]
        await filled(history, goals)

        async def counted(**wanted: Any) -> dict[str, int]:
            (found,) = await tally_goals(history, GoalFilter(**wanted), [EVER], by_action=True)
            return {name: tally.ended for name, tally in found.items()}

        assert await counted() == {"/robot1/dock": 2, "/robot2/dock": 1, "/robot2/undock": 1}
        assert await counted(namespace="/robot2") == {"/robot2/dock": 1, "/robot2/undock": 1}
        assert await counted(action_names=frozenset({"/robot1/dock"})) == {"/robot1/dock": 2}
        assert await counted(origin="external") == {"/robot2/dock": 1}
        assert await counted(error_codes=frozenset({"blocked"})) == {"/robot1/dock": 1}
        hall = frozenset({"/robot1/dock", "/robot2/undock"})
        assert await counted(among=hall) == {"/robot1/dock": 2, "/robot2/undock": 1}
        assert await counted(among=hall, namespace="/robot2") == {"/robot2/undock": 1}
        assert await counted(among=frozenset()) == {}
        await history.notes.replace_tags("goal-0002", ["blocked", "maintenance"])
        await history.notes.replace_tags("goal-0004", ["maintenance"])
        await history.notes.replace_tags("goal-0005", ["maintenance"])
        assert await counted(tags=frozenset({"maintenance", "blocked"})) == {"/robot1/dock": 1, "/robot2/undock": 1}
        assert await counted(tags=frozenset({"maintenance"}), namespace="/robot1") == {"/robot1/dock": 1}
        assert await counted(tags=frozenset({"never"})) == {}


def test_percentiles_are_interpolated() -> None:
    tally = Tally(durations=[np.array([4000.0, 1000.0]), np.array([]), np.array([2000.0, 3000.0])])
    assert tally.percentiles(50, 90) == [2.5, pytest.approx(3.7)]
    assert Tally().percentiles(50, 90) == [None, None]


def test_a_goal_without_its_end_has_no_duration() -> None:
    (found,) = tallied([ended(1, took=None)], [EVER])
    assert (found["/dock"].ended, found["/dock"].percentiles(50)) == (1, [None])


def test_many_durations_are_parsed_in_pieces() -> None:
    numbers = [*range(0, 3_000_000, 7), 1]
    pieces = list(tallies.parse_durations(",".join(map(str, numbers))))
    assert len(pieces) > 10
    assert np.concatenate(pieces).tolist() == numbers


async def test_a_long_error_code_is_shortened(database_url: str, tmp_path: Path) -> None:
    """PostgreSQL refuses index entries of more than 2,700 bytes, and so the goal."""
    async with open_at(database_url, tmp_path) as history:
        await filled(history, [ended(1, GoalStatus.ABORTED, error=GoalError("ö\0" * 5000, "why"))])
        (found,) = await tally_goals(history, GoalFilter(), [EVER], by_action=True)
        assert found["/dock"].errors == {"ö" * MAX_CODE: 1}


async def test_an_index_is_used(database_url: str, tmp_path: Path) -> None:
    """They read it alone."""

    def read(connection: sa.Connection) -> None:
        span = (NOW, NOW + timedelta(seconds=20))
        tallies.read_rows(connection, GoalFilter(), [span], by_action=False)

    async with open_at(database_url, tmp_path, max_waiting=3000) as history:
        await filled(history, [ended(n, goal=b"x" * 1000) for n in range(2000)])
        alone = "COVERING INDEX goals_by_end"
        if database_url.startswith("postgresql"):
            await vacuum(database_url)
            alone = "Index Only Scan using goals_by_end"
        assert alone in await history.database.read(explain, read)


async def vacuum(url: str) -> None:
    """Do what PostgreSQL does by itself after some time: note what is where, and what everybody can see."""
    connection = await asyncpg.connect(url)
    await connection.execute("VACUUM ANALYZE goals")
    await connection.close()


async def test_others_are_answered_meanwhile(sqlite_url: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    started, go_on = asyncio.Event(), asyncio.Event()
    loop = asyncio.get_running_loop()

    def slow(*_: object) -> list[Any]:
        loop.call_soon_threadsafe(started.set)
        asyncio.run_coroutine_threadsafe(go_on.wait(), loop).result(30)
        return []

    async with open_at(sqlite_url, tmp_path) as history:
        monkeypatch.setattr(tallies, "read_rows", slow)
        asking = asyncio.gather(*(tally_goals(history, GoalFilter(), [EVER], by_action=True) for _ in range(5)))
        await started.wait()
        assert await history.get("goal-0001") is None
        go_on.set()
        assert await asking == [[]] * 5
