"""A history that is still being loaded loses nothing, and says nothing before it can."""

import asyncio
import threading
from collections.abc import Callable
from pathlib import Path

import pytest

from dock_gateway.errors import Unavailable
from dock_gateway.goals import GoalStatus
from dock_gateway.history import Acknowledgement, late
from dock_gateway.history.late import LateHistory, Loaded
from dock_gateway.history.spool import Spool
from dock_gateway.history.sql import SqlHistory
from tests.support.history import EVERYTHING, NOW, make_event, make_goal, open_at, until, written

Load = Callable[[Spool], Loaded]


@pytest.fixture(autouse=True)
def _soon(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(late, "LOAD_AFTER", 0.01)


@pytest.fixture
def gate() -> threading.Event:
    """Until it is set, nothing is loaded."""
    return threading.Event()


@pytest.fixture
def load(sqlite_url: str, gate: threading.Event) -> Load:
    def load(spool: Spool) -> Loaded:
        assert gate.wait(10.0)
        return SqlHistory(sqlite_url, spool, max_waiting=1000, max_age=3600.0, max_bytes=10**9)

    return load


async def test_what_comes_while_it_is_loaded(
    load: Load, gate: threading.Event, sqlite_url: str, tmp_path: Path
) -> None:
    history = LateHistory(load, Spool(tmp_path / "spool"))
    goal = make_goal(1, GoalStatus.PENDING)
    await history.add(goal)
    goal.advance(GoalStatus.EXECUTING, NOW)
    history.record(goal)
    history.record(make_goal(2))
    history.record_event(make_event(1))
    history.record_event(make_event(2))
    assert (history.stats().database_reachable, history.stats().spooled) == (False, 1)
    asking = [
        asyncio.create_task(work)
        for work in (history.get("goal-0001"), history.by_key("k"), history.claim("k", "goal-0003", "f"))
    ]
    await asyncio.sleep(0.1)
    assert not any(task.done() for task in asking)
    gate.set()
    found, _, claimed = await asyncio.gather(*asking)
    assert found is not None
    assert found.status is GoalStatus.EXECUTING
    assert claimed == ("goal-0003", "f")
    await history.add(make_goal(3), "k")
    await until(lambda: not history.stats().waiting and not history.stats().spooled)
    events = await history.events_after(
        make_event(1).id or "", goal_id=None, action_name=None, topics=EVERYTHING, limit=10
    )
    assert [event.data for event in events or []] == [make_event(2).data]
    await history.acknowledgements.write("a", Acknowledgement("Ada", NOW))
    assert await history.acknowledgements.read() == {"a": Acknowledgement("Ada", NOW)}
    await history.close()
    async with open_at(sqlite_url, tmp_path) as again:
        assert [goal.goal_id for goal in await again.unfinished()] == ["goal-0001"]
        assert await again.by_key("k") is not None


async def test_a_process_that_ends_before_it_is_loaded(
    load: Load, gate: threading.Event, sqlite_url: str, tmp_path: Path
) -> None:
    history = LateHistory(load, Spool(tmp_path / "spool"))
    await history.add(make_goal(1, GoalStatus.PENDING))
    history.record(make_goal(2))
    history.record_event(make_event(1))
    await history.close()
    gate.set()
    async with open_at(sqlite_url, tmp_path) as again:
        await written(again)
        assert {goal.goal_id for goal in (await again.get("goal-0001"), await again.get("goal-0002")) if goal} == {
            "goal-0001",
            "goal-0002",
        }


async def test_one_that_is_killed_before_it_is_loaded(
    load: Load, sqlite_url: str, tmp_path: Path, gate: threading.Event
) -> None:
    spool = Spool(tmp_path / "spool")
    history = LateHistory(load, spool)
    await history.add(make_goal(1, GoalStatus.PENDING))
    await spool.close()  # as the system does
    async with open_at(sqlite_url, tmp_path) as again:
        assert await again.get("goal-0001") is not None
    gate.set()


async def test_one_that_cannot_be_loaded(tmp_path: Path) -> None:
    def load(_: Spool) -> Loaded:
        raise ImportError("no such database")

    history = LateHistory(load, Spool(tmp_path / "spool"))
    await history.opened()
    with pytest.raises(Unavailable, match="no such database"):
        await history.get("goal-0001")
    await history.add(make_goal(1))
    assert history.stats().spooled == 1
    for number in range(30_000):
        history.record_event(make_event(number, "battery", droppable=True))
    assert history.stats().waiting == 20_000
    assert history.stats().dropped == 10_001
    assert "no such database" in (history.stats().last_error or "")
    await history.close()


async def test_no_goal_runs_that_cannot_be_kept(load: Load, tmp_path: Path, gate: threading.Event) -> None:
    (tmp_path / "spool").touch()
    history = LateHistory(load, Spool(tmp_path / "spool"))
    with pytest.raises(Unavailable, match="must not run"):
        await history.add(make_goal(1))
    gate.set()
    await history.close()
