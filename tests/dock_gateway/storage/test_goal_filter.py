"""Goals that are asked for by robot, action, state, origin and time are the same ones in memory and in databases."""

from collections.abc import AsyncIterator
from datetime import timedelta
from pathlib import Path

import pytest

from dock_gateway.core.goal import GoalError, GoalStatus
from dock_gateway.storage import GoalFilter, History
from dock_gateway.storage.queries import cursor_of
from tests.support.history import NOW, make_goal, open_at, page_of, written

GOALS = [
    make_goal(1, GoalStatus.SUCCEEDED, "/dock"),
    make_goal(2, GoalStatus.ABORTED, "/robot1/dock", error=GoalError("blocked", "by a chair")),
    make_goal(3, GoalStatus.EXECUTING, "/robot1/arm/dock", origin="external"),
    make_goal(4, GoalStatus.SUCCEEDED, "/robot10/dock", verb="dock"),
    make_goal(5, GoalStatus.CANCELED, "/Robot1/dock", origin="external", error=GoalError("stopped", "by Ada")),
    make_goal(6, GoalStatus.SUCCEEDED, "/robot1/fibonacci"),
]


@pytest.fixture(params=["memory", "sqlite", "postgresql", "waiting"])
def place(request: pytest.FixtureRequest) -> tuple[str, str]:
    """Where the goals are, and the URL of that; `waiting`: some of them are stored and wait besides."""
    kind = {"memory": None, "waiting": "sqlite"}.get(request.param, request.param)
    return request.param, "memory:" if kind is None else request.getfixturevalue(f"{kind}_url")


@pytest.fixture
async def history(place: tuple[str, str], tmp_path: Path) -> AsyncIterator[History]:
    kind, url = place
    async with open_at(url, tmp_path) as history:
        await fill(history)
        if kind == "waiting":
            for goal in GOALS[::2]:
                history.record(goal)
        yield history


async def fill(history: History) -> None:
    for goal in GOALS:
        history.record(goal)
    await written(history)


async def numbers(history: History, **wanted: object) -> list[int]:
    return [int(goal.goal_id[-4:]) for goal in await page_of(history, **wanted)]


PICKED: list[tuple[dict[str, object], list[int]]] = [
    ({}, [6, 5, 4, 3, 2, 1]),
    ({"namespace": "/robot1"}, [6, 3, 2]),
    ({"namespace": "/robot1/arm"}, [3]),
    ({"namespace": "/robot"}, []),
    ({"action_names": {"/dock", "/robot10/dock"}}, [4, 1]),
    ({"action_names": {"/dock"}, "namespace": "/robot1"}, []),
    ({"among": frozenset({"/dock", "/robot1/dock"})}, [2, 1]),
    ({"among": frozenset({"/dock", "/robot1/dock"}), "namespace": "/robot1"}, [2]),
    ({"among": frozenset({"/dock"}), "action_names": {"/robot1/dock"}}, []),
    ({"among": frozenset()}, []),
    ({"statuses": {GoalStatus.ABORTED, GoalStatus.EXECUTING}}, [3, 2]),
    ({"error_codes": {"blocked", "stopped"}}, [5, 2]),
    ({"error_codes": {"blocked"}, "statuses": {GoalStatus.CANCELED}}, []),
    ({"origin": "external"}, [5, 3]),
    ({"origin": "gateway", "statuses": {GoalStatus.SUCCEEDED}, "namespace": "/robot1"}, [6]),
    ({"verb": "dock"}, [4]),
    ({"verb": "undock"}, []),
    ({"since": NOW + timedelta(seconds=4)}, [6, 5, 4]),
    ({"until": NOW + timedelta(seconds=3)}, [2, 1]),
    ({"since": NOW + timedelta(seconds=2), "until": NOW + timedelta(seconds=2, microseconds=1)}, [2]),
    ({"since": NOW + timedelta(days=1)}, []),
    ({"id_prefix": "goal-"}, [6, 5, 4, 3, 2, 1]),
    ({"id_prefix": "goal-0003"}, [3]),
    ({"id_prefix": "goal-000", "namespace": "/robot1"}, [6, 3, 2]),
    ({"id_prefix": "goal-01"}, []),
    ({"id_prefix": "GOAL"}, []),
    ({"id_prefix": "goal_000"}, []),
    ({"id_prefix": "goal%"}, []),
]


async def test_goals_are_picked(history: History) -> None:
    for wanted, expected in PICKED:
        assert await numbers(history, **wanted) == expected, wanted


async def test_pages_of_goals_that_are_picked(history: History) -> None:
    """The goal that a page begins after need not be one of those that are asked for."""
    assert await numbers(history, namespace="/robot1", limit=2) == [6, 3]
    assert await numbers(history, namespace="/robot1", limit=2, before=cursor_of(make_goal(3))) == [2]
    assert await numbers(history, namespace="/robot1", limit=2, before=cursor_of(make_goal(5))) == [3, 2]


async def test_the_names_of_actions_with_goals(history: History) -> None:
    assert await history.action_names() == {goal.action_name for goal in GOALS}
    history.record(make_goal(7, action="/robot2/dock"))
    assert "/robot2/dock" in await history.action_names()


def test_the_root_namespace_is_all() -> None:
    assert all(GoalFilter(namespace="/").matches(goal) for goal in GOALS)
