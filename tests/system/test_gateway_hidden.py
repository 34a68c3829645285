"""Hidden names: what a relay offers in a hidden namespace, as TurtleBot 4's does, is not a second robot."""

from collections.abc import Iterator
from contextlib import ExitStack
from typing import Any

import pytest

from tests.support.domain import ros_domain
from tests.support.gateway import RunningGateway, running_gateway, running_servers, running_talker
from tests.support.waiting import wait_until

pytest.importorskip("irobot_create_msgs", reason="`make test` installs the interface packages of tests/interfaces")
pytestmark = pytest.mark.ros

ROBOT, HIDDEN = "/robot2", "/robot2/_do_not_use"
BATTERY = "sensor_msgs/msg/BatteryState"


@pytest.fixture(scope="module")
def domain() -> Iterator[int]:
    """A robot whose docking actions and battery are in two namespaces, one of which is hidden."""
    with ros_domain() as domain, ExitStack() as stack:
        for namespace in (ROBOT, HIDDEN):
            offer = ("--offer", "create3", "--robot", namespace, "--outcomes", "slow")
            stack.enter_context(running_servers(domain, *offer))
        topics = [f"--topic={namespace}/battery_status:{BATTERY}:5" for namespace in (HIDDEN, ROBOT)]
        stack.enter_context(running_talker(domain, *topics))
        yield domain


@pytest.fixture(scope="module")
def gateway(domain: int) -> Iterator[RunningGateway]:
    with running_gateway(domain) as gateway:
        both = {f"{ROBOT}/dock", f"{HIDDEN}/dock"}
        wait_until(lambda: both <= actions(gateway, "?hidden=true").keys(), "the actions")
        wait_until(lambda: all(names in robots(gateway) for names in (ROBOT, "/talker0")), "the robots")
        yield gateway


def robots(gateway: RunningGateway) -> list[str]:
    return [robot["name"] for robot in gateway.http.get("/robots").raise_for_status().json()["robots"]]


def actions(gateway: RunningGateway, query: str = "") -> dict[str, Any]:
    found = gateway.http.get(f"/actions{query}").raise_for_status().json()["actions"]
    return {action["action_name"]: action for action in found}


def test_one_robot_is_found(gateway: RunningGateway) -> None:
    assert robots(gateway) == ["/", ROBOT, "/talker0"]
    assert f"{ROBOT}/dock" in actions(gateway)
    assert not [name for name in actions(gateway) if name.startswith(HIDDEN)]
    hidden = actions(gateway, "?hidden=true")[f"{HIDDEN}/dock"]
    assert (hidden["verb"], hidden["available"]) == (None, True)
    assert gateway.http.get(f"/robots?robot={HIDDEN}").json()["code"] == "robot_not_found"
    shown = {action["name"]: action["hidden"] for action in gateway.http.get("/graph").json()["actions"]}
    assert (shown[f"{ROBOT}/dock"], shown[f"{HIDDEN}/dock"]) == (False, True)
    refused = gateway.http.get("/actions?hidden=perhaps")
    assert (refused.status_code, refused.json()["code"]) == (422, "invalid_field")


def test_a_stop_reaches_goals_on_hidden_actions_too(gateway: RunningGateway) -> None:
    wait_until(lambda: actions(gateway, "?hidden=true")[f"{HIDDEN}/dock"]["answering"], "the server")
    sent = gateway.http.post(f"/actions{HIDDEN}/dock/goals", json={})
    assert sent.status_code == 202, sent.text
    goal_id = sent.json()["goal_id"]
    gateway.wait_for_goal(goal_id, "executing")
    assert gateway.http.get("/dock", params={"robot": ROBOT}).json()["goals"] == []
    assert goal_id in gateway.stop_once(f"?robot={ROBOT}")["canceling"]
    gateway.wait_for_goal(goal_id, "canceled")


def test_a_hidden_namespace_is_a_robot_if_the_settings_name_it(domain: int) -> None:
    with running_gateway(domain, namespace=HIDDEN) as gateway:
        wait_until(lambda: ROBOT in robots(gateway), "the other robot")
        assert HIDDEN in robots(gateway)
        gateway.wait_until_ready()
        assert f"{HIDDEN}/dock" in actions(gateway)
        assert gateway.http.get("/readyz").json()["action_server"]["action_name"] == f"{HIDDEN}/dock"
