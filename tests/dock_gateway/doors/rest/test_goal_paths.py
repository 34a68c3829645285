"""Every operation below a path of goals judges the goal by that path, whichever operations there are."""

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from starlette.testclient import TestClient

from dock_gateway.app import create_app
from dock_gateway.core.goal import Goal, GoalStatus
from dock_gateway.goals.goals import Goals
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.http.parts import Parts
from dock_gateway.http.quotas import Quotas
from dock_gateway.settings import Settings
from tests.support.audit import audit_parts
from tests.support.history import make_goal

SETTINGS = Settings(database_url="sqlite:////nowhere")
OPENAPI = json.loads((Path(__file__).parents[4] / "frontend/openapi.json").read_text())
OPERATIONS = [
    (method, path)
    for path, item in OPENAPI["paths"].items()
    for method in item
    if "{goal_id}" in path and not path.startswith("/goals/")
]
ID = "00000000-0000-4000-8000-000000000001"
GOALS = {
    "/dock": make_goal(1, GoalStatus.EXECUTING, "/robot1/dock", verb="dock", goal_id=ID),
    "/undock": make_goal(2, GoalStatus.EXECUTING, "/robot1/undock", verb="undock", goal_id=ID),
    "/actions/robot1/spin/goals": make_goal(3, GoalStatus.EXECUTING, "/robot1/spin", verb=None, goal_id=ID),
}


class OneGoal(Parts):
    """A gateway with one goal, and an action of each name."""

    def __init__(self, goal: Goal) -> None:
        self._goal = goal
        self.canceled: list[str] = []
        super().__init__(
            {
                **audit_parts(),
                Settings: SETTINGS,
                Quotas: Quotas(SETTINGS),
                Goals: SimpleNamespace(get=self._get),
                ActionRegistry: SimpleNamespace(find=self._find),
            }
        )

    async def _get(self, _: str, *__: object) -> Goal:
        return self._goal

    async def _find(self, name: str) -> Any:
        return SimpleNamespace(name=name, canceler=SimpleNamespace(cancel=self._cancel))

    async def _cancel(self, goal: Goal) -> None:
        self.canceled.append(goal.action_name)


def path_of(path: str) -> str:
    """The path of goals that an operation is below."""
    return path.partition("/{goal_id}")[0].replace("{name}", "robot1/spin")


def test_the_operations_are_those_that_are_known() -> None:
    assert {path_of(path) for _, path in OPERATIONS} == GOALS.keys()
    below = {(method, path.partition("/{goal_id}")[2]) for method, path in OPERATIONS}
    assert below >= {("get", ""), ("post", "/cancel"), ("get", "/events")}


@pytest.mark.parametrize(("method", "path"), OPERATIONS)
@pytest.mark.parametrize("on", GOALS)
def test_a_goal_of_another_path_is_not_there(method: str, path: str, on: str) -> None:
    parts = OneGoal(GOALS[on])
    asked = path.replace("{name}", "robot1/spin").replace("{goal_id}", ID)
    with TestClient(create_app(SETTINGS, parts), "http://127.0.0.1:8000", raise_server_exceptions=False) as client:
        answer = client.request(method, asked)
    if on != path_of(path):
        assert (answer.status_code, answer.json()["code"]) == (404, "goal_not_found")
        assert parts.canceled == []
    elif not path.endswith("/events"):  # a stream needs more of a gateway
        assert answer.status_code == (202 if path.endswith("/cancel") else 200)
