"""Documents of a real gateway as those of the hub."""

from copy import deepcopy
from datetime import UTC, datetime
from typing import Any

import orjson
import pytest
from pydantic import BaseModel

from dock_gateway.core.goal import GoalStatus
from dock_gateway.fleet import alert as alerts
from dock_gateway.fleet import alert_kinds
from dock_gateway.fleet.schema import Alert, Robot
from dock_gateway.goals.action_schema import ActionServer
from dock_gateway.goals.approval_schema import Approval
from dock_gateway.goals.schema import GoalState
from dock_gateway.stop.schema import StopState
from dock_hub import fields, goal_documents, renaming
from dock_hub.site_view import MAX_ROBOTS, SiteView
from tests.dock_hub.documents import AT, ROBOT, decoded, ended_goal


def test_a_robot_gets_the_site_in_front_of_each_name() -> None:
    robot = renaming.read_robots("berlin", [ROBOT | {"only": "a newer site has"}])[0]
    assert robot["site"] == "berlin"
    assert robot["name"] == "/berlin/robot1"
    assert robot["battery_topic"] == "/berlin/robot1/battery_status"
    assert robot["stop"]["robots"] == ["/berlin/robot1"]
    assert robot["dock"]["action_name"] == "/berlin/robot1/dock"
    assert robot["last_goal"]["action_name"] == "/berlin/robot1/dock"
    assert (robot["join"], robot["default"], robot["last_goal"]["last_event_id"]) == (None, False, None)
    assert robot.keys() == ROBOT.keys() | {"site"}
    assert b"/robot1" not in orjson.dumps(robot).replace(b"/berlin/robot1", b"")


@pytest.mark.parametrize("model", [Robot, Alert, Approval, ActionServer, GoalState, StopState])
def test_each_name_of_the_ros_graph_is_marked(model: type[BaseModel]) -> None:
    graph = {"name", "robot", "robots", "action_name", "topic", "battery_topic", "node"}
    for name in graph & model.model_fields.keys():
        assert renaming.readers_of(model)[name] is not fields.as_is, name


def test_what_has_no_names_comes_through_as_it_is() -> None:
    battery = {"state": {"percentage": 0.5, "location": "slot 1"}, "stale": False, "newer": [1]}
    assert renaming.read_robots("berlin", [ROBOT | {"battery": battery}])[0]["battery"] == battery


def test_the_robot_without_a_namespace_has_the_name_of_the_site() -> None:
    assert renaming.read_robots("oslo", [ROBOT | {"name": "/"}])[0]["name"] == "/oslo"
    assert renaming.read_names("oslo", ["/", "/a/b"]) == ["/oslo", "/oslo/a/b"]


def test_an_alert_of_the_gateway_is_one_of_the_site() -> None:
    alert = decoded(alerts.Alert(alert_kinds.HISTORY_LOST, None, AT, "History lost", "gone").document(None))
    (renamed,) = renaming.read_alerts("berlin", [alert])
    assert (renamed["robot"], renamed["site"], renamed["id"]) == ("/berlin", "berlin", f"berlin.{alert['id']}")
    assert renamed["started_at"] == alert["started_at"]


def test_a_goal_comes_through_as_it_was_but_for_its_name_and_its_last_event() -> None:
    goal = ended_goal()
    renamed = goal_documents.read_goal("berlin", decoded(goal.document()))
    expected = decoded(goal.document()) | {"action_name": "/berlin/robot1/dock", "last_event_id": None}
    assert decoded(renamed.document()) == expected
    assert [each.kind for each in goal_documents.ends_of(renamed)] == ["status", "result"]


def test_a_result_finishes_a_goal() -> None:
    goal = ended_goal()
    running = goal_documents.read_goal("berlin", decoded(goal.document()) | {"status": "executing", "result": None})
    event = {"status": "aborted", "result": {"b": 1}, "error": None, "time": "2026-11-27T12:00:01Z"}
    goal_documents.finish_goal(running, event)
    assert (running.status, running.result, running.error) == (GoalStatus.ABORTED, b'{"b":1}', None)
    assert running.finished_at == datetime(2026, 11, 27, 12, 0, 1, tzinfo=UTC)


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("goal_id", "../etc"),
        ("action_name", "robot1/dock"),
        ("action_name", "/robot1/../x"),
        ("action_type", "a\0b"),
        ("status", "fine"),
        ("created_at", "2026-11-27T12:00:00"),
        ("updated_at", 5),
        ("feedback_count", -1),
        ("error", "late"),
        ("goal", [1]),
        ("origin", "hub"),
    ],
)
def test_what_is_not_a_goal_is_refused_with_a_sentence(field: str, value: object) -> None:
    document = decoded(ended_goal().document()) | {field: value}
    with pytest.raises(fields.ForeignDocumentError):
        goal_documents.read_goal("berlin", document)


@pytest.mark.parametrize("nonsense", [None, 5, "text", {}, [None], [[]], [{"name": 1}], [ROBOT | {"stop": None}]])
def test_nonsense_is_refused(nonsense: object) -> None:
    for read in (renaming.read_robots, renaming.read_alerts, renaming.read_names, renaming.read_approvals):
        with pytest.raises(fields.ForeignDocumentError):
            read("berlin", deepcopy(nonsense))
    with pytest.raises(fields.ForeignDocumentError):
        goal_documents.read_goal("berlin", nonsense)


def nested(depth: int) -> Any:
    return [nested(depth - 1)] if depth else []


@pytest.mark.parametrize("value", [nested(250), "x" * fields.MAX_DOCUMENT])
def test_a_value_that_nobody_could_be_shown_is_refused(value: Any) -> None:
    with pytest.raises(fields.ForeignDocumentError):
        renaming.read_robots("berlin", [ROBOT | {"battery": value}])


def test_a_site_has_only_so_many_robots() -> None:
    view = SiteView("berlin")
    every = [ROBOT | {"name": f"/berlin/r{number}"} for number in range(MAX_ROBOTS)]
    view.put_robots(every)
    with pytest.raises(fields.ForeignDocumentError, match="more than"):
        view.put_robots([ROBOT])
    with pytest.raises(fields.ForeignDocumentError, match="a list has"):
        renaming.read_names("berlin", ["/r1"] * (fields.MAX_ENTRIES + 1))
    assert len(view.robots) == MAX_ROBOTS


def test_a_message_that_is_too_large_is_left_out() -> None:
    document = decoded(ended_goal().document()) | {"goal": {"a": "x" * goal_documents.MAX_MESSAGE}}
    renamed = goal_documents.read_goal("berlin", document)
    assert (renamed.goal, renamed.result) == (None, b'{"b":[null]}')
