"""Every action on the graph, in any namespace: found as it appears, used with the same verbs, gone when it goes."""

from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from tests.support.gateway import ACTION, CHARGING, LOW, RunningGateway, running_dock_server, running_program
from tests.support.processes import Process
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros

FIBONACCI = [0, 1, 1, 2, 3, 5, 8, 13, 21, 34, 55]


@contextmanager
def fibonacci(domain: int, *ros_args: str) -> Iterator[Process]:
    with running_program(domain, "fibonacci_action_server", "-p", "step_period:=0.05", *ros_args) as process:
        yield process


def names(gateway: RunningGateway) -> list[str]:
    return [action["action_name"] for action in gateway.http.get("/actions").json()["actions"]]


def wait_for_action(gateway: RunningGateway, name: str) -> None:
    def answering() -> bool:
        answer = gateway.http.get(f"/actions{name}")
        return answer.is_success and bool(answer.json()["answering"])

    wait_until(answering, f"{name} answers")


def test_an_action_appears_is_used_and_goes(gateway: RunningGateway, shared_domain: int) -> None:
    assert names(gateway) == [ACTION, "/disconnect_from_charging_dock"]
    with fibonacci(shared_domain), gateway.stream("?action=fibonacci") as stream:
        wait_for_action(gateway, "/fibonacci")
        info = gateway.http.get("/actions/fibonacci").json()
        assert info["action_type"] == "action_tutorials_interfaces/action/Fibonacci"
        assert (info["installed"], info["hint"], info["verb"]) == (True, None, None)

        response = gateway.http.post("/actions/fibonacci/goals", json={"order": 10})
        assert response.status_code == 202
        goal_id = response.json()["goal_id"]
        assert response.headers["location"] == f"/goals/{goal_id}"
        assert stream.until_type("feedback")["feedback"]["partial_sequence"][:3] == [0, 1, 1]
        assert stream.until_type("result")["result"]["sequence"] == FIBONACCI
        goal = gateway.http.get(response.headers["location"]).json()
        assert (goal["status"], goal["goal"]) == ("succeeded", {"order": 10})
        page = gateway.http.get("/actions/fibonacci/goals").json()["goals"]
        assert [entry["goal_id"] for entry in page] == [goal_id]
        assert gateway.http.get(f"/actions/fibonacci/goals/{goal_id}").json() == goal
        assert page == gateway.http.get("/goals?action=/fibonacci").json()["goals"] == [goal]

        running = gateway.http.post("/actions/fibonacci/goals", json={"order": 40}).json()["goal_id"]
        assert gateway.http.post(f"/actions/fibonacci/goals/{running}/cancel").status_code == 202
        assert stream.until_type("result")["status"] == "canceled"

        empty = gateway.http.post("/actions/fibonacci/goals")
        assert (empty.status_code, empty.json()["code"]) == (422, "invalid_field")
        defaults = gateway.http.post("/actions/fibonacci/goals", json={}, headers={"Prefer": "wait=50"})
        assert defaults.json()["goal"] == {"order": 0}

        wrong = gateway.http.post("/actions/fibonacci/goals", json={"order": "ten", "sequence": []})
        assert [error["path"] for error in wrong.json()["errors"]] == ["order", "sequence"]
    wait_until(lambda: "/fibonacci" not in names(gateway), "the action has gone")
    assert gateway.http.get("/actions/fibonacci").status_code == 404


def test_stop_reaches_every_action_of_the_robot(gateway: RunningGateway, shared_domain: int) -> None:
    with fibonacci(shared_domain), gateway.stream("?action=fibonacci") as stream:
        wait_for_action(gateway, "/fibonacci")
        goal_id = gateway.http.post("/actions/fibonacci/goals", json={"order": 40}).json()["goal_id"]
        assert goal_id in gateway.stop_once()["canceling"]
        assert stream.until_type("result")["status"] == "canceled"


def test_a_robot_is_a_namespace(gateway: RunningGateway, shared_domain: int) -> None:
    assert gateway.http.post("/dock?robot=/robot1").status_code == 404
    with (
        running_dock_server(shared_domain, "-r", "__ns:=/robot1"),
        running_dock_server(shared_domain, "-r", "__ns:=/fleet/robot2"),
    ):
        wait_for_action(gateway, f"/robot1{ACTION}")
        wait_for_action(gateway, f"/fleet/robot2{ACTION}")
        wait_until(lambda: gateway.http.get("/stop?robot=/robot1").is_success, "the robot is known")
        with gateway.stream("?robot=/robot1&include=battery,cmd_vel,system") as stream:
            snapshot = stream.next()
            assert snapshot["goals"] == []
            assert snapshot["docking"]["dock"] == {
                "action_name": f"/robot1{ACTION}",
                "action_type": "action_tutorials_interfaces/action/ConnectToChargingDock",
                "available": True,
                "answering": True,
                "duplicate": False,
            }
            assert snapshot["docking"]["undock"] == {
                "action_name": "/robot1/disconnect_from_charging_dock",
                "action_type": "action_tutorials_interfaces/action/DisconnectFromChargingDock",
                "available": False,
                "answering": False,
                "duplicate": False,
            }
            gateway.http.put("/battery/publisher?robot=/robot1", json={"state": LOW, "rate_hz": 5}).raise_for_status()
            gateway.http.put(
                "/battery/publisher?robot=/fleet/robot2", json={"state": CHARGING, "rate_hz": 5}
            ).raise_for_status()
            second = gateway.http.post("/dock?robot=/fleet/robot2", headers={"Prefer": "wait=50"}).json()
            assert (second["action_name"], second["status"]) == (f"/fleet/robot2{ACTION}", "succeeded")

            first = gateway.http.post("/dock?robot=/robot1").json()
            assert first["action_name"] == f"/robot1{ACTION}"
            turning = stream.until(lambda e: e["type"] == "cmd_vel" and e["cmd_vel"]["angular"]["z"] != 0)
            assert turning["robot"] == "/robot1"
            assert gateway.http.get("/battery?robot=/robot1").json()["state"]["power_supply_status"] == 3
            assert gateway.http.get("/battery").json()["state"] is None
            assert [goal["goal_id"] for goal in gateway.http.get("/dock?robot=/robot1").json()["goals"]] == [
                first["goal_id"]
            ]
            goals = gateway.http.get("/dock").json()["goals"]
            assert [goal["goal_id"] for goal in goals] == [first["goal_id"], second["goal_id"]]

            assert gateway.stop_once("?robot=/fleet/robot2")["canceling"] == []
            assert gateway.goal(first["goal_id"])["status"] == "executing"
            assert gateway.stop_once("?robot=/robot1")["canceling"] == [first["goal_id"]]
            assert stream.until_type("result")["status"] == "canceled"
            goal_actions = {e["action_name"] for e in stream.seen if "goal_id" in e}
            assert goal_actions == {f"/robot1{ACTION}"}


def test_stop_without_a_robot_stops_them_all(gateway: RunningGateway, shared_domain: int) -> None:
    with running_dock_server(shared_domain, "-r", "__ns:=/robot1"):
        wait_for_action(gateway, f"/robot1{ACTION}")
        gateway.http.put("/battery/publisher?robot=/robot1", json={"state": LOW, "rate_hz": 5}).raise_for_status()

        def accepted() -> str | None:
            """The server of the test before has the same name, and may just have gone."""
            answer = gateway.http.post("/dock?robot=/robot1")
            return answer.json()["goal_id"] if answer.status_code == 202 else None

        goal_id = wait_until(accepted, "a goal is accepted")
        assert gateway.stop_once()["canceling"] == [goal_id]
        assert gateway.wait_for_goal(goal_id, "canceled")["error"]["code"] == "stopped"
