"""A goal is read and canceled only where its path names it; `/goals` names every goal."""

from types import SimpleNamespace
from typing import Any

import pytest

from dock_gateway.core.access import ANYBODY
from dock_gateway.core.errors import NotFound
from dock_gateway.core.goal import Goal, GoalStatus
from dock_gateway.doors.rest import sent_goals
from dock_gateway.doors.rest.sent_goals import GoalsAt
from dock_gateway.goals.goals import Goals
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.http.parts import Parts
from tests.support.history import make_goal

GOALS = {
    "dock": make_goal(1, GoalStatus.EXECUTING, action="/robot1/dock", verb="dock"),
    "undock": make_goal(2, GoalStatus.EXECUTING, action="/robot1/undock", verb="undock"),
    "spin": make_goal(3, GoalStatus.EXECUTING, action="/robot1/spin", verb=None),
}
PLACES = {
    GoalsAt("/dock", "dock"): {"dock"},
    GoalsAt("/undock", "undock"): {"undock"},
    GoalsAt("/actions/robot1/spin/goals", action="/robot1/spin"): {"spin"},
    GoalsAt("/actions/robot1/dock/goals", action="/robot1/dock"): {"dock"},
    GoalsAt("/goals"): {"dock", "undock", "spin"},
}
ROUTERS = {"/dock": sent_goals.dock, "/undock": sent_goals.undock, "/goals": sent_goals.anywhere}


def having(goal: Goal, canceled: list[str]) -> Parts:
    """A gateway with one goal, and an action for each name."""

    async def get(_: str, *__: object) -> Goal:
        return goal

    async def find(name: str) -> Any:
        async def cancel(each: Goal) -> None:
            canceled.append(each.goal_id)

        return SimpleNamespace(name=name, canceler=SimpleNamespace(cancel=cancel))

    goals: Any = SimpleNamespace(get=get)
    actions: Any = SimpleNamespace(find=find)
    return Parts({Goals: goals, ActionRegistry: actions})


def endpoint(place: GoalsAt, ending: str) -> Any:
    """The function of the route at a place whose path ends like that."""
    router = ROUTERS.get(place.path, sent_goals.of_action)
    (found,) = (route.endpoint for route in router.routes if route.path.endswith(ending))  # type: ignore[attr-defined]
    return found


@pytest.mark.parametrize("place", PLACES, ids=lambda place: place.path)
@pytest.mark.parametrize("name", GOALS)
async def test_a_goal_is_canceled_only_where_its_path_names_it(place: GoalsAt, name: str) -> None:
    canceled: list[str] = []
    goal, cancel = GOALS[name], endpoint(place, "/cancel")
    asked = cancel(goal.goal_id, having(goal, canceled), ANYBODY, place)
    if name in PLACES[place]:
        assert (await asked).headers["Location"] == f"{place.path}/{goal.goal_id}"
        assert canceled == [goal.goal_id]
        return
    with pytest.raises(NotFound) as refused:
        await asked
    assert refused.value.code == "goal_not_found"
    assert canceled == []


@pytest.mark.parametrize("place", [each for each in PLACES if each.path != "/goals"], ids=lambda place: place.path)
@pytest.mark.parametrize("name", GOALS)
async def test_a_goal_is_read_only_where_its_path_names_it(place: GoalsAt, name: str) -> None:
    goal, get = GOALS[name], endpoint(place, "/{goal_id}")
    asked = get(goal.goal_id, having(goal, []), place)
    if name in PLACES[place]:
        assert (await asked).headers["Location"] == f"{place.path}/{goal.goal_id}"
        return
    with pytest.raises(NotFound):
        await asked
