"""A goal is at `/goals/{goal_id}`. The other spellings lead there, with any goal, and are not in the document."""

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from starlette.testclient import TestClient

from dock_gateway.app import create_app
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.goal import Goal, GoalStatus
from dock_gateway.goals.goal_documents import GoalDocuments
from dock_gateway.goals.goals import Goals
from dock_gateway.goals.known_robots import KnownRobots
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.http.parts import Parts
from dock_gateway.http.quotas import Quotas
from dock_gateway.settings import Settings
from dock_gateway.storage import GoalFilter
from tests.support.audit import audit_parts
from tests.support.history import HistoryInMemory, make_goal
from tests.support.robot_actions import make_robot_actions

SETTINGS = Settings(database_url="sqlite:////nowhere")
PATHS = json.loads((Path(__file__).parents[4] / "frontend/openapi.json").read_text())["paths"]
ID = "00000000-0000-4000-8000-000000000001"
GOALS = {
    "dock": make_goal(1, GoalStatus.EXECUTING, "/robot1/dock", verb="dock", goal_id=ID),
    "undock": make_goal(2, GoalStatus.EXECUTING, "/robot1/undock", verb="undock", goal_id=ID),
    "spin": make_goal(3, GoalStatus.EXECUTING, "/robot1/spin", verb=None, goal_id=ID),
}
SPELLINGS = ("/goals", "/dock", "/undock", "/actions/robot1/spin/goals", "/actions/robot1/dock/goals")


class OneGoal(Parts):
    """A gateway with one goal, and an action of each name."""

    def __init__(self, goal: Goal) -> None:
        self._goal = goal
        self.canceled: list[str] = []
        self.listed: list[GoalFilter] = []
        actions = make_robot_actions(SETTINGS)
        super().__init__(
            {
                **audit_parts(),
                Settings: SETTINGS,
                Quotas: Quotas(SETTINGS),
                KnownRobots: SimpleNamespace(require=self._require),
                Goals: SimpleNamespace(get=self._get, page=self._page),
                Fanout: Fanout(queue_limit=1),
                GoalDocuments: GoalDocuments(HistoryInMemory()),
                ActionRegistry: SimpleNamespace(find=self._find),
                type(actions): actions,
            }
        )

    async def _require(self, *_: object) -> None:
        """Every robot is known."""

    async def _get(self, _: str, *__: object) -> Goal:
        return self._goal

    async def _page(self, wanted: GoalFilter, *_: object) -> tuple[list[Goal], None]:
        self.listed.append(wanted)
        return [self._goal], None

    async def _find(self, name: str) -> Any:
        return SimpleNamespace(name=name, canceler=SimpleNamespace(cancel=self._cancel))

    async def _cancel(self, goal: Goal) -> None:
        self.canceled.append(goal.action_name)


def client_of(parts: Parts) -> TestClient:
    return TestClient(create_app(SETTINGS, parts), "http://127.0.0.1:8000", raise_server_exceptions=False)


def test_a_goal_has_one_path_in_the_document() -> None:
    found = {path for path in PATHS if "{goal_id}" in path}
    assert found >= {"/goals/{goal_id}", "/goals/{goal_id}/cancel", "/goals/{goal_id}/events"}
    assert all(path.startswith("/goals/{goal_id}") for path in found)
    assert "get" not in PATHS["/actions/{name}/goals"]


@pytest.mark.parametrize("spelling", SPELLINGS)
@pytest.mark.parametrize("on", GOALS)
def test_every_spelling_leads_to_any_goal(spelling: str, on: str) -> None:
    parts = OneGoal(GOALS[on])
    with client_of(parts) as client:
        seen = client.get(f"{spelling}/{ID}")
        assert seen.status_code == 200
        assert seen.json() == client.get(f"/goals/{ID}").json()
        assert (seen.json()["tags"], seen.json()["notes"]) == ([], [])
        canceled = client.post(f"{spelling}/{ID}/cancel")
        assert (canceled.status_code, canceled.headers["location"]) == (202, f"/goals/{ID}")
        assert canceled.json() == seen.json() | {"tags": None, "notes": None}
        assert parts.canceled == [GOALS[on].action_name]
        assert client.get(f"{spelling}/{ID}/events?robto=x").json()["code"] == "invalid_field"


def test_lists_have_what_a_goal_has_by_itself() -> None:
    parts = OneGoal(GOALS["dock"])
    with client_of(parts) as client:
        alone = client.get(f"/goals/{ID}").json()
        for path in ("/goals?verb=dock", "/dock?status=executing", "/undock", "/actions/robot1/spin/goals?limit=1"):
            assert client.get(path).json() == {"goals": [alone], "next_cursor": None}
        assert client.get("/dock?verb=undock").status_code == 422
    assert [wanted.verb for wanted in parts.listed] == ["dock", "dock", "undock", None]
    assert [wanted.action_names for wanted in parts.listed] == [frozenset()] * 3 + [frozenset({"/robot1/spin"})]
