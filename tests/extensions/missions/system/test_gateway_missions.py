"""Missions of real gateways: a robot that does one thing after the other, also if a gateway is killed in between."""

import signal
import time
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest

from dock_gateway.extensions.missions.runner import INTERVAL
from tests.support.docking import FAST, UNMEASURED
from tests.support.docking import PATIENT as RELIABLE
from tests.support.gateway import (
    CHARGING,
    LOW,
    RunningGateway,
    ready_gateway,
    running_dock_server,
    running_gateway,
    running_program,
    running_service_node,
)
from tests.support.waiting import PATIENCE, wait_until

pytestmark = pytest.mark.ros

DOCK: dict[str, Any] = {"dock": {}}
FIBONACCI: dict[str, Any] = {"action": {"name": "/fibonacci", "goal": {"order": 4}}}


def post(gateway: RunningGateway, *steps: dict[str, Any], **fields: Any) -> str:
    """Queue a mission; return its id."""
    answer = gateway.http.post("/missions", json={"steps": [*steps], **fields})
    assert answer.status_code == 201, answer.text
    mission_id: str = answer.json()["mission_id"]
    return mission_id


def mission(gateway: RunningGateway, mission_id: str) -> dict[str, Any]:
    found: dict[str, Any] = gateway.http.get(f"/missions/{mission_id}").raise_for_status().json()
    return found


def until(gateway: RunningGateway, mission_id: str, status: str, **fields: Any) -> dict[str, Any]:
    """Wait until a mission has a state, and these fields; return it."""
    wanted = {"status": status, **fields}
    deadline = time.monotonic() + PATIENCE
    while not wanted.items() <= (found := mission(gateway, mission_id)).items():
        assert time.monotonic() < deadline, found
        time.sleep(0.05)
    return found


def change(gateway: RunningGateway, mission_id: str, verb: str) -> None:
    gateway.http.post(f"/missions/{mission_id}/{verb}").raise_for_status()


def goals(gateway: RunningGateway) -> list[dict[str, Any]]:
    """The goals of all actions, oldest first."""
    found: list[dict[str, Any]] = gateway.http.get("/goals").raise_for_status().json()["goals"]
    return found[::-1]


def test_one_step_after_the_other(domain: int) -> None:
    with ready_gateway(domain) as gateway, running_program(domain, "fibonacci_action_server"):
        wait_until(lambda: gateway.http.get("/actions/fibonacci").status_code == 200, "the action")
        gateway.publish(LOW)
        with gateway.stream("?include=mission") as stream:
            first = post(gateway, DOCK, {"wait": {"seconds": 0.2}}, FIBONACCI, {"wait": {"person": True}}, name="Night")
            second = post(gateway, FIBONACCI)
            sooner = post(gateway, FIBONACCI, priority=90)
            until(gateway, first, "running", waits_for="goal")
            until(gateway, second, "queued", waits_for="turn")
            gateway.publish(CHARGING)
            until(gateway, first, "held", held_for="person", step=3)
            assert [mission(gateway, each)["status"] for each in (second, sooner)] == ["queued", "queued"]
            change(gateway, first, "continue")
            for each in (first, sooner, second):
                until(gateway, each, "succeeded")
            ended = [
                event["mission"]["mission_id"]
                for event in [
                    stream.until(lambda event: event["type"] == "mission" and event["mission"]["status"] == "succeeded")
                    for _ in range(3)
                ]
            ]
        assert ended == [first, sooner, second]
        found = mission(gateway, first)
        assert [step["status"] for step in found["steps"]] == 4 * ["succeeded"]
        sent = goals(gateway)
        assert [goal["goal_id"] for goal in sent[:2]] == [step["goal_id"] for step in found["steps"][::2]]
        assert [goal["action_name"].rpartition("/")[2] for goal in sent[1:]] == 3 * ["fibonacci"]
        assert {goal["origin"] for goal in sent} == {"automation"}


def label(gateway: RunningGateway, robot: str, *groups: str) -> None:
    body = {"display_name": None, "groups": [*groups]}
    gateway.http.put("/label", params={"robot": robot}, json=body).raise_for_status()


def publish_battery(gateway: RunningGateway, robot: str, percentage: float) -> None:
    """Publish a battery state, and go on with it."""
    body = {"state": {**LOW, "percentage": percentage}, "rate_hz": 2.0}
    gateway.http.put("/battery/publisher", params={"robot": robot}, json=body).raise_for_status()


def test_a_mission_for_a_group_goes_to_the_robot_with_the_most_charge(domain: int) -> None:
    with ExitStack() as stack:
        for robot in ("/robot1", "/robot2"):
            stack.enter_context(running_dock_server(domain, "-r", f"__ns:={robot}"))
        gateway = stack.enter_context(running_gateway(domain, namespace="/robot1"))
        wait_until(lambda: len(gateway.http.get("/robots").json()["robots"]) == 2, "the robots")
        hold = {"wait": {"person": True}}
        first, second, third = (post(gateway, hold, group="pickers") for _ in range(3))
        until(gateway, first, "queued", waits_for="group", robot=None)
        for robot in ("/robot1", "/robot2"):
            label(gateway, robot, "pickers")
        until(gateway, first, "queued", waits_for="robot", robot=None)
        gateway.http.post(f"/missions/{third}/move", json={"before": second}).raise_for_status()
        publish_battery(gateway, "/robot2", 0.7)
        until(gateway, first, "held", robot="/robot2")
        publish_battery(gateway, "/robot1", 0.9)
        until(gateway, third, "held", robot="/robot1")
        assert mission(gateway, second)["robot"] is None
        gateway.http.put(f"/missions/{second}", json={"name": "Short", "steps": [hold]}).raise_for_status()
        gateway.http.post("/stop", params={"robot": "/robot1"}).raise_for_status()
        change(gateway, third, "cancel")
        until(gateway, third, "canceled")
        gateway.http.delete("/stop", params={"robot": "/robot1"}).raise_for_status()
        until(gateway, second, "queued", waits_for="continue", name="Short")
        change(gateway, second, "continue")
        until(gateway, second, "held", robot="/robot1", group="pickers")


def test_a_stop_holds_a_mission_until_somebody_continues_it(domain: int) -> None:
    with ready_gateway(domain) as gateway:
        gateway.publish(LOW)
        docking = post(gateway, DOCK)
        until(gateway, docking, "running", waits_for="goal")
        gateway.http.post("/stop", json={"by": "Bob"}).raise_for_status()
        held = until(gateway, docking, "held", held_for="stop", waits_for="stop_released")
        until_error = lambda: mission(gateway, docking)["steps"][0]["error"]  # noqa: E731
        assert wait_until(until_error, "the end of the goal")["code"] == "stopped"
        assert gateway.http.post(f"/missions/{docking}/continue").json()["code"] == "stop_latched"
        gateway.http.delete("/stop").raise_for_status()
        until(gateway, docking, "held", waits_for="continue")
        assert len(goals(gateway)) == 1
        change(gateway, docking, "continue")
        again = until(gateway, docking, "running", waits_for="goal")
        assert again["steps"][0]["attempt"] == held["steps"][0]["attempt"] + 1
        gateway.stop_once()  # one that does not stay holds it, too
        until(gateway, docking, "held", held_for="stop")
        waiting = post(gateway, {"wait": {"seconds": 600}})
        until(gateway, waiting, "queued")  # the robot has a mission still
        change(gateway, docking, "cancel")
        until(gateway, docking, "canceled")
        until(gateway, waiting, "running", waits_for="time")
        gateway.stop_once()
        until(gateway, waiting, "held", held_for="stop")
        assert len(goals(gateway)) == 2


def test_people_come_first(domain: int) -> None:
    with ready_gateway(domain) as gateway:
        gateway.publish(LOW)
        theirs = gateway.http.post("/dock").raise_for_status().json()["goal_id"]
        docking = post(gateway, DOCK, {"wait": {"seconds": 600}})
        until(gateway, docking, "running", waits_for="other_goal")
        gateway.http.post(f"/goals/{theirs}/cancel").raise_for_status()
        found = until(gateway, docking, "running", waits_for="goal")
        gateway.http.post(f"/goals/{found['steps'][0]['goal_id']}/cancel").raise_for_status()
        until(gateway, docking, "held", held_for="canceled")
        change(gateway, docking, "skip")
        until(gateway, docking, "running", step=1)
        change(gateway, docking, "cancel")
        until(gateway, docking, "canceled")
        assert gateway.http.post(f"/missions/{docking}/cancel").json()["code"] == "mission_ended"


def test_a_goal_that_takes_too_long_or_is_canceled_with_its_mission(domain: int) -> None:
    with ready_gateway(domain) as gateway:
        gateway.publish(LOW)
        late = post(gateway, {**DOCK, "timeout_s": 5.0})  # a disk may take a second before the goal is sent
        found = until(gateway, late, "failed")
        assert found["error"]["code"] == "step_timeout"
        gateway.wait_for_goal(found["steps"][0]["goal_id"], "canceled")
        canceled = post(gateway, DOCK)
        until(gateway, canceled, "running", waits_for="goal")
        change(gateway, canceled, "cancel")
        found = until(gateway, canceled, "canceled")
        gateway.wait_for_goal(found["steps"][0]["goal_id"], "canceled")


@pytest.mark.parametrize("after", [0.0, 0.05, 0.3])
def test_a_gateway_that_is_killed_sends_no_goal_twice(domain: int, tmp_path: Path, after: float) -> None:
    kept = {"database_url": f"sqlite:///{tmp_path}/history.db", "spool_path": f"{tmp_path}/spool"}
    with running_program(domain, "fibonacci_action_server", "-p", "step_period:=0.1"):
        with running_gateway(domain, **kept) as first:
            wait_until(lambda: first.http.get("/actions/fibonacci").status_code == 200, "the action")
            patrol = post(first, *(3 * [FIBONACCI]), {"wait": {"seconds": 0.1}}, FIBONACCI)
            time.sleep(after)
            first.process.send_signal(signal.SIGKILL)
            first.process.wait()
        with running_gateway(domain, **kept) as second:
            found = until(second, patrol, "succeeded")
            sent = [goal["goal_id"] for goal in goals(second)]
            assert sent == [step["goal_id"] for step in found["steps"] if step["action"] is not None]
            assert [step["attempt"] for step in found["steps"]] == 5 * [1]


def test_a_step_waits_for_its_server(domain: int) -> None:
    with running_gateway(domain) as gateway:
        later = post(gateway, FIBONACCI)
        until(gateway, later, "running", waits_for="server")
        with running_program(domain, "fibonacci_action_server"):
            until(gateway, later, "succeeded")


def test_two_gateways_on_one_database_carry_out_a_mission_once(domain: int, tmp_path: Path) -> None:
    database = f"sqlite:///{tmp_path}/history.db"
    with (
        running_dock_server(domain),
        running_program(domain, "fibonacci_action_server"),
        running_gateway(domain, database_url=database) as first,
        running_gateway(domain, database_url=database) as second,
    ):
        for gateway in (first, second):
            wait_until(lambda gateway=gateway: gateway.http.get("/actions/fibonacci").status_code == 200, "the action")
        patrol = post(first, *(4 * [FIBONACCI]))
        for gateway in (first, second):
            until(gateway, patrol, "succeeded")
        assert len(goals(second)) == 4
        change_at_other = post(second, {"wait": {"person": True}})
        until(first, change_at_other, "held")
        change(first, change_at_other, "continue")
        until(second, change_at_other, "succeeded")


def test_steps_are_repeated_once_a_round_also_if_the_gateway_is_killed(domain: int, tmp_path: Path) -> None:
    kept = {"database_url": f"sqlite:///{tmp_path}/history.db", "spool_path": f"{tmp_path}/spool"}
    away: dict[str, Any] = {"action": {"name": "/nobody", "goal": {}}, "timeout_s": 1.0}
    steps: list[dict[str, Any]] = [
        {"repeat": {"times": 3, "steps": [{"first_that_works": [away, FIBONACCI]}]}},
        {"wait": {"seconds": 0}, "name": "home"},
    ]
    with running_program(domain, "fibonacci_action_server", "-p", "step_period:=0.1"):
        with running_gateway(domain, **kept) as first:
            wait_until(lambda: first.http.get("/actions/fibonacci").status_code == 200, "the action")
            rounds = post(first, *steps)
            until(first, rounds, "running", step=3)
            first.process.send_signal(signal.SIGKILL)
            first.process.wait()
        with running_gateway(domain, **kept) as second:
            found = until(second, rounds, "succeeded")
            assert [step["path"] for step in found["steps"]] == [
                "0",
                "0.repeat.steps.0",
                "0.repeat.steps.0.first_that_works.0",
                "0.repeat.steps.0.first_that_works.1",
                "1",
            ]
            assert (found["steps"][0]["repeat"], found["steps"][3]["attempt"]) == ({"times": 3, "round": 3}, 3)
            assert len(goals(second)) == 3


MESSAGES = {"allow_services": "/robot1/*", "allow_publish": "/robot1/light", "server_wait": "0.5"}


def test_services_are_called_messages_published_and_people_told(domain: int, tmp_path: Path) -> None:
    kept = {"database_url": f"sqlite:///{tmp_path}/history.db", "spool_path": f"{tmp_path}/spool"}
    echo: dict[str, Any] = {"call": {"service": "/robot1/echo", "request": {"data": True}}}
    light: dict[str, Any] = {"publish": {"topic": "/robot1/light", "type": "std_msgs/msg/Bool"}}
    never: dict[str, Any] = {"call": {"service": "/robot1/never"}, "timeout_s": 60.0}
    with running_service_node(domain):
        with running_gateway(domain, **MESSAGES, **kept) as gateway:
            wait_until(lambda: gateway.http.get("/services/robot1/never").status_code == 200, "the service")
            wrong = gateway.http.post("/missions", json={"steps": [light, echo | {"call": {"service": "/other"}}]})
            assert (wrong.status_code, wrong.json()["code"]) == (403, "not_allowed")
            first = post(
                gateway, echo, light, {"notify": {"text": "Load me"}}, {"wait": {"person": True}}, name="Night"
            )
            found = until(gateway, first, "held", held_for="person")
            assert [step["status"] for step in found["steps"][:3]] == 3 * ["succeeded"]
            alerts = lambda: [each["detail"] for each in gateway.http.get("/alerts").json()["alerts"]]  # noqa: E731
            wait_until(lambda: "Load me" in alerts(), "the alert")
            change(gateway, first, "cancel")
            second = post(gateway, never)
            until(gateway, second, "running")
            time.sleep(0.3)
            gateway.process.send_signal(signal.SIGKILL)
            gateway.process.wait()
        with running_gateway(domain, **MESSAGES, **kept) as gateway:
            until(gateway, second, "running", waits_for="answer")
            change(gateway, second, "cancel")


def test_automatic_docking_waits_for_a_mission(domain: int) -> None:
    pytest.importorskip("dock_gateway.extensions.automation")
    rule = {"name": "Low", "mode": "on", "robots": {"all": True}, "battery": {"below": 0.3, "idle_s": 10}}

    def waits_for() -> str:
        found = gateway.http.get("/automation/rules/low").raise_for_status().json()
        reason: str = found["applies_to"][0]["waits_for"]
        return reason

    with ready_gateway(domain) as gateway:
        gateway.publish(LOW)
        waiting = post(gateway, {"wait": {"seconds": 600}})
        until(gateway, waiting, "running")
        gateway.http.put("/automation/rules/low", json=rule).raise_for_status()
        wait_until(lambda: waits_for() == "at_work", "the rule")
        change(gateway, waiting, "cancel")
        until(gateway, waiting, "canceled")
        wait_until(lambda: waits_for() != "at_work", "the end of the mission")
        wait_until(lambda: goals(gateway), "the goal of the rule")


LIMITS = {"below": 0.25, "charge_to": 0.3}
# A robot near its dock, whose battery takes 4 s for a percent.
NEAR = (
    "-p",
    FAST,
    "-p",
    "start_x:=-1.1",
    "-p",
    "start_y:=0.1",
    "-p",
    "start_theta:=-0.1",
    "-p",
    "charge_current:=65.0",
)
STEADY = ("-p", "controller:=dock_pose", "-p", RELIABLE, "-p", UNMEASURED)


def until_stage(gateway: RunningGateway, mission_id: str, stage: str) -> dict[str, Any]:
    """Wait until the robot of a mission has come so far with its charging; return the mission."""
    wait_until(lambda: (mission(gateway, mission_id)["recharge"] or {"stage": None})["stage"] == stage, stage)
    return mission(gateway, mission_id)


def kill(gateway: RunningGateway) -> None:
    gateway.process.send_signal(signal.SIGKILL)
    gateway.process.wait()


def test_a_robot_returns_to_charge_and_its_mission_goes_on(domain: int, tmp_path: Path) -> None:
    """Also if the gateway is killed while the robot docks, and while it charges: each goal is sent once."""
    kept = {"database_url": f"sqlite:///{tmp_path}/history.db", "spool_path": f"{tmp_path}/spool"}
    with (
        running_program(domain, "dock_simulator", *NEAR),
        running_program(domain, "docking_server", *STEADY),
        running_program(domain, "fibonacci_action_server"),
    ):
        with running_gateway(domain, **kept) as gateway:
            gateway.wait_until_ready()
            wait_until(lambda: gateway.http.get("/actions/fibonacci").status_code == 200, "the action")
            wait_until(lambda: gateway.http.get("/battery").json()["percentage"], "the battery")
            round_ = post(gateway, FIBONACCI, battery=LIMITS)
            until_stage(gateway, round_, "docking")
            wait_until(lambda: mission(gateway, round_)["recharge"]["goal_id"], "the goal")
            kill(gateway)
        with running_gateway(domain, **kept) as gateway:
            until_stage(gateway, round_, "charging")
            kill(gateway)
        with running_gateway(domain, **kept) as gateway:
            assert until_stage(gateway, round_, "charging")["steps"][0]["attempt"] == 0
            until_stage(gateway, round_, "undocking")
            found = until(gateway, round_, "succeeded", recharge=None)
            sent = goals(gateway)
            assert [goal["status"] for goal in sent] == 3 * ["succeeded"]
            assert [goal["verb"] for goal in sent] == ["dock", "undock", None]
            assert sent[2]["goal_id"] == found["steps"][0]["goal_id"]


def test_a_stop_holds_a_return_too(domain: int) -> None:
    with ready_gateway(domain) as gateway:
        gateway.publish(LOW)
        round_ = post(gateway, {"wait": {"seconds": 600}}, battery=LIMITS)
        until(gateway, round_, "running", waits_for="goal")
        gateway.http.post("/stop").raise_for_status()
        until(gateway, round_, "held", held_for="stop")
        gateway.http.delete("/stop").raise_for_status()
        until(gateway, round_, "held", waits_for="continue")
        time.sleep(2 * INTERVAL)
        assert len(goals(gateway)) == 1
        change(gateway, round_, "continue")
        until(gateway, round_, "running", waits_for="goal")
        gateway.publish(CHARGING)
        until_stage(gateway, round_, "charging")
        assert len(goals(gateway)) == 2


def test_a_rule_asks_a_mission_to_let_its_robot_charge(domain: int) -> None:
    pytest.importorskip("dock_gateway.extensions.automation")
    rule = {"name": "Low", "mode": "on", "robots": {"all": True}, "battery": {"below": 0.3, "idle_s": 10}}
    with ready_gateway(domain) as gateway:
        gateway.publish(LOW | {"percentage": 0.1})
        waiting = post(gateway, {"wait": {"seconds": 600}})
        until(gateway, waiting, "running", waits_for="time")
        gateway.http.put("/automation/rules/low", json=rule).raise_for_status()
        until_stage(gateway, waiting, "docking")
        wait_until(lambda: goals(gateway), "the goal of the mission")
        assert gateway.http.get("/automation/decisions").json()["decisions"] == []
