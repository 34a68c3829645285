"""A docking server in another namespace than its robot, one robot by two names, and two robots by one name."""

from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import orjson
import pytest
from sensor_msgs.msg import BatteryState

from tests.support.gateway import RunningGateway, running_gateway, running_program, running_servers
from tests.support.installed import needs
from tests.support.observer import Observer, ros_observer
from tests.support.waiting import wait_until

pytest.importorskip("nav2_msgs", reason="`make test` installs the interface packages of tests/interfaces")
pytestmark = pytest.mark.ros

ROBOT, DOCK, UNDOCK = "/robot1", "/docking/dock_robot", "/docking/undock_robot"
LINES = [f'robots."{ROBOT}".dock_action = "{DOCK}"', f'robots."{ROBOT}".undock_action = "{UNDOCK}"']
LOW = BatteryState(percentage=0.1, power_supply_status=BatteryState.POWER_SUPPLY_STATUS_DISCHARGING)
NAV2 = {"use_dock_id": True, "dock_id": "slow"}


@pytest.fixture
def base(domain: int) -> Iterator[Observer]:
    with ros_observer(domain, "base") as base:
        yield base


def robots(gateway: RunningGateway) -> dict[str, dict[str, Any]]:
    found = gateway.http.get("/robots").raise_for_status().json()["robots"]
    return {robot["name"]: robot for robot in found}


def alerts(gateway: RunningGateway, kind: str) -> list[dict[str, Any]]:
    found = gateway.http.get("/alerts").raise_for_status().json()["alerts"]
    return [alert for alert in found if alert["kind"] == kind]


def test_the_answer_names_the_settings_that_join_a_robot(domain: int, base: Observer, tmp_path: Path) -> None:
    with running_servers(domain, "--offer", "nav2", "--robot", "/docking"), ExitStack() as stack:
        stack.enter_context(base.publishing(LOW, f"{ROBOT}/battery_status", heard=False))
        with running_gateway(domain) as gateway:
            wait_until(lambda: (robots(gateway).get(ROBOT) or {}).get("join"), "the lines")
            wait_until(lambda: robots(gateway)["/docking"]["undock"], "both actions")
            assert robots(gateway)[ROBOT]["join"]["settings"] == LINES
            for query, status in (("", 503), (f"?robot={ROBOT}", 404)):
                refused = gateway.http.post(f"/dock{query}")
                problem = refused.json()
                assert (refused.status_code, problem["settings"]) == (status, LINES), problem
                for part in (DOCK, f"{ROBOT}/battery_status", LINES[0], ROBOT):
                    assert part in problem["detail"]
            assert f"?robot={ROBOT}" in gateway.http.post("/dock").json()["detail"]
            unknown = gateway.http.post("/dock?robot=/robot9").json()
            assert (unknown["code"], unknown["settings"]) == ("robot_not_found", LINES)
            ready = gateway.http.get("/readyz").json()
            assert (ready["ready"], ready["robots"], ready["settings"]) == (False, ["/docking", ROBOT], LINES)
            (alert,) = wait_until(lambda: alerts(gateway, "split_robot"), "the alert")
            assert (alert["robot"], alert["severity"]) == (ROBOT, "warning")
            assert gateway.http.get(f"/readyz?robot={ROBOT}").json()["problems"] == [alert["detail"]]
            assert not gateway.http.get("/goals").json()["goals"], "nothing is joined by itself"
        (file := tmp_path / "gateway.toml").write_text("\n".join(LINES))
        with running_gateway(domain, config=str(file)) as gateway:
            the_joined_robot_docks(gateway)


def the_joined_robot_docks(gateway: RunningGateway) -> None:
    at = {"robot": ROBOT}

    def server() -> dict[str, Any]:
        found: dict[str, Any] = (robots(gateway).get(ROBOT) or {}).get("dock") or {}
        return found

    wait_until(lambda: server().get("action_name") == DOCK and server()["answering"], "the docking server")
    wait_until(lambda: robots(gateway)[ROBOT]["battery"]["state"], "the battery")
    assert robots(gateway).keys() == {"/", ROBOT}
    assert gateway.http.get("/readyz", params=at).json()["ready"]
    with gateway.stream(f"?robot={ROBOT}") as stream:
        goal_id = gateway.http.post("/dock", params=at, json=NAV2).raise_for_status().json()["goal_id"]
        stream.until(lambda event: event.get("goal_id") == goal_id and event.get("status") == "executing")
    assert [goal["goal_id"] for goal in robots(gateway)[ROBOT]["goals"]] == [goal_id]
    assert [goal["goal_id"] for goal in gateway.http.get("/goals", params=at).json()["goals"]] == [goal_id]
    gateway.http.post("/stop", params=at, json={"by": "Ada"}).raise_for_status()
    gateway.wait_for_goal(goal_id, "canceled")
    held = gateway.http.post("/dock", params=at, json=NAV2)
    assert (held.status_code, held.json()["code"]) == (409, "stop_latched")
    gateway.http.delete("/stop", params=at).raise_for_status()
    done = gateway.http.post("/dock", params=at, json={"dock_id": "home"}, headers={"Prefer": "wait=60"})
    assert done.json()["status"] == "succeeded", done.text
    assert not alerts(gateway, "split_robot")


@needs("automation")
def test_one_robot_by_two_names_gets_no_goal_by_itself(domain: int, base: Observer) -> None:
    names = [ROBOT, "/relay"]
    with ExitStack() as stack:
        stack.enter_context(running_servers(domain, "--offer", "create3", "--robot", ROBOT, "--also", "/relay/"))
        for name in names:
            stack.enter_context(base.publishing(LOW, f"{name}/battery_status", heard=False))
        gateway = stack.enter_context(running_gateway(domain))
        rule = {"name": "Low", "mode": "on", "robots": {"names": names}, "battery": {"below": 0.3, "idle_s": 10}}
        wait_until(lambda: set(names) <= robots(gateway).keys(), "both names")
        gateway.http.put("/automation/rules/low", json=rule | {"by": "Ada"}).raise_for_status()

        def waits() -> set[str]:
            (found,) = gateway.http.get("/automation/rules").raise_for_status().json()["rules"]
            return {each["waits_for"] for each in found["applies_to"] if each["robot"] in names}

        wait_until(lambda: waits() == {"shared_action"}, "the rule")
        (alert,) = wait_until(lambda: alerts(gateway, "robot_seen_twice"), "the alert")
        for part in (*names, f"{ROBOT}/docking_server", ".dock_action = ", "ALLOW_SHARED_SERVERS"):
            assert part in alert["detail"]
        assert not gateway.http.get("/goals").json()["goals"]
        with running_gateway(domain, robots=orjson.dumps({ROBOT: {"dock_action": "/relay/dock"}}).decode()) as joined:
            wait_until(lambda: (robots(joined).get(ROBOT) or {}).get("dock"), "the robot")
            wait_until(lambda: "/relay" in robots(joined), "the other battery")
            assert robots(joined)["/relay"]["dock"] is None
            assert robots(joined)[ROBOT]["dock"]["action_name"] == "/relay/dock"
            assert not alerts(joined, "robot_seen_twice")


def test_two_bases_are_named_where_a_goal_fails(domain: int) -> None:
    with ExitStack() as stack:
        for _ in range(2):
            stack.enter_context(running_program(domain, "dock_simulator"))
        stack.enter_context(running_servers(domain, "--offer", "create3", "--outcomes", "gave-up"))
        gateway = stack.enter_context(running_gateway(domain))
        (alert,) = wait_until(lambda: alerts(gateway, "duplicate_base"), "the alert")
        assert (alert["robot"], alert["severity"]) == ("/", "critical")
        for part in ("2 nodes /dock_simulator", "/cmd_vel", "/odom", "__ns", "ROS_DOMAIN_ID"):
            assert part in alert["detail"]
        assert alert["detail"] in gateway.http.get("/readyz").json()["problems"]
        gateway.wait_until_ready()
        goal = gateway.http.post("/dock", headers={"Prefer": "wait=60"}).json()
        assert goal["status"] == "aborted"
        assert "2 nodes /dock_simulator" in goal["error"]["detail"]


def test_one_base_is_no_finding(domain: int) -> None:
    with running_program(domain, "dock_simulator"), running_gateway(domain) as gateway, ros_observer(domain) as logger:
        logger.record(BatteryState, "/battery_status")
        wait_until(lambda: robots(gateway)["/"]["battery"]["state"], "the battery")
        with ros_observer(domain, "second") as second, second.publishing(BatteryState(), "/second/battery_status"):
            wait_until(lambda: "/second" in robots(gateway), "the other robot")
        assert not alerts(gateway, "duplicate_base")


def test_an_action_of_another_type_than_the_settings_say_is_named(domain: int) -> None:
    kind = "nav2_msgs/action/UndockRobot"
    with (
        running_servers(domain, "--offer", "nav2"),
        running_gateway(domain, dock_action="dock_robot", dock_action_type=kind) as gateway,
    ):
        (alert,) = wait_until(lambda: alerts(gateway, "wrong_topic_type"), "the alert")
        assert alert["robot"] == "/"
        for part in ("/dock_robot", kind, "nav2_msgs/action/DockRobot", "DOCK_GATEWAY_DOCK_ACTION_TYPE"):
            assert part in alert["detail"]
