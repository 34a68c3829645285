"""Goals are counted by action, for a limited number of actions."""

from datetime import UTC, datetime, timedelta
from types import SimpleNamespace

import pytest
from prometheus_client import CollectorRegistry

from dock_gateway.core.goal import Goal, GoalError, GoalStatus, Verb
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.http.parts import Parts
from dock_gateway.observability.goal_metrics import GoalMetrics
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway.settings import Settings

NOON = datetime(2026, 1, 1, 12, tzinfo=UTC)
DOCK, UNDOCK, FIBONACCI = "/robot1/connect_to_charging_dock", "/robot1/disconnect_from_charging_dock", "/fibonacci"
VERBS: dict[str, Verb] = {DOCK: "dock", UNDOCK: "undock"}


class Scene:
    """Actions of `/robot1` and others. At most two have series, or as many as are on the graph."""

    def __init__(self) -> None:
        self.registry = CollectorRegistry()
        self.on_graph = {DOCK, UNDOCK}
        self.actions = SimpleNamespace(on_end=[], on_lost=[], get=lambda name: name if name in self.on_graph else None)
        robot = SimpleNamespace(namespace="/robot1")
        robots = SimpleNamespace(owner=lambda name: robot if name.startswith("/robot1/") else None)
        parts = Parts({Settings: Settings(max_actions=2), ActionRegistry: self.actions, RobotRegistry: robots})
        GoalMetrics(self.registry, parts)

    def end(self, action: str, status: GoalStatus, seconds: float = 30.0, retries: int | None = None) -> None:
        goal = Goal("id", action, "pkg/action/Any", NOON, verb=VERBS.get(action), retries=retries)
        goal.advance(status, NOON + timedelta(seconds=seconds))
        for notify in self.actions.on_end:
            notify(goal)

    def lose(self, action: str) -> Goal:
        goal = Goal("id", action, "pkg/action/Any", NOON, verb=VERBS.get(action), status=GoalStatus.EXECUTING)
        goal.lose(GoalError("action_server_lost", ""), NOON)
        for notify in self.actions.on_lost:
            notify(goal)
        return goal

    def value(self, name: str, **labels: str) -> float | None:
        return self.registry.get_sample_value(f"dock_gateway_{name}", labels)

    def actions_with_series(self) -> set[str]:
        samples = (sample for metric in self.registry.collect() for sample in metric.samples)
        return {sample.labels["action"] for sample in samples if "action" in sample.labels}


@pytest.fixture
def scene() -> Scene:
    return Scene()


def test_how_a_goal_ended(scene: Scene) -> None:
    scene.end(DOCK, GoalStatus.SUCCEEDED, 40.0, retries=2)
    scene.end(DOCK, GoalStatus.SUCCEEDED, 50.0, retries=1)
    scene.end(FIBONACCI, GoalStatus.ABORTED)
    docking = {"robot": "/robot1", "action": DOCK, "verb": "dock"}
    assert scene.value("goals_ended_total", **docking, status="succeeded") == 2
    assert scene.value("goal_retries_total", **docking) == 3
    assert scene.value("goal_duration_seconds_sum", verb="dock", status="succeeded") == 90.0
    assert scene.value("goal_duration_seconds_bucket", verb="dock", status="succeeded", le="45.0") == 1
    other = {"robot": "", "action": FIBONACCI, "verb": "other", "status": "aborted"}
    assert scene.value("goals_ended_total", **other) == 1


def test_durations_are_there_from_the_start(scene: Scene) -> None:
    assert scene.value("goal_duration_seconds_count", verb="dock", status="aborted") == 0


def test_a_goal_that_was_rejected_took_no_time(scene: Scene) -> None:
    scene.end(DOCK, GoalStatus.REJECTED)
    assert scene.value("goals_ended_total", robot="/robot1", action=DOCK, verb="dock", status="rejected") == 1
    assert scene.value("goal_duration_seconds_count", verb="dock", status="rejected") is None


def test_the_clock_of_a_robot_that_is_ahead(scene: Scene) -> None:
    scene.end(DOCK, GoalStatus.SUCCEEDED, -3.0)
    assert scene.value("goal_duration_seconds_sum", verb="dock", status="succeeded") == 0.0


def test_a_lost_goal_has_not_ended(scene: Scene) -> None:
    goal = scene.lose(UNDOCK)
    for notify in scene.actions.on_end:  # it is not expected back
        notify(goal)
    labels = {"robot": "/robot1", "action": UNDOCK, "verb": "undock"}
    assert scene.value("goals_lost_total", **labels) == 1
    assert scene.value("goals_ended_total", **labels, status="lost") is None


def test_actions_that_left_make_room_for_others(scene: Scene) -> None:
    scene.end("/gone1", GoalStatus.SUCCEEDED)
    scene.lose("/gone2")
    assert scene.actions_with_series() == {"/gone1", "/gone2"}
    scene.end(DOCK, GoalStatus.SUCCEEDED)
    scene.end(UNDOCK, GoalStatus.SUCCEEDED)
    scene.end(DOCK, GoalStatus.SUCCEEDED)
    assert scene.actions_with_series() == {DOCK, UNDOCK}
    assert scene.value("goals_ended_total", robot="/robot1", action=DOCK, verb="dock", status="succeeded") == 2
    for number in range(100):
        scene.end(f"/new{number}", GoalStatus.SUCCEEDED)
        assert len(scene.actions_with_series()) <= 3
    assert {DOCK, UNDOCK} < scene.actions_with_series()
