"""Docking servers that are not ours: `/dock` and `/undock` work with nav2's and the Create 3's protocols."""

from collections.abc import Iterator
from typing import Any

import pytest

from tests.support.gateway import RunningGateway, running_dock_server, running_gateway, running_servers
from tests.support.waiting import wait_until

pytest.importorskip("nav2_msgs", reason="`make test` installs the interface packages of tests/interfaces")

NAV2, CREATE3 = "/dock_robot", "/dock"


@pytest.fixture
def gateway(domain: int) -> Iterator[RunningGateway]:
    """One for each test: a goal that follows upon the end of another server would be sent to that one."""
    with running_gateway(domain) as gateway:
        yield gateway


def dock_server(gateway: RunningGateway, robot: str = "/") -> dict[str, Any]:
    (found,) = gateway.http.get(f"/robots?robot={robot}").raise_for_status().json()["robots"]
    server: dict[str, Any] = found["dock"]
    return server


def wait_until_docked_by(gateway: RunningGateway, action: str, robot: str = "/") -> None:
    """Wait until this action docks the robot, and its server is there."""

    def docks() -> bool:
        server = dock_server(gateway, robot)
        return bool(server["action_name"] == action and server["available"] and server["answering"])

    wait_until(docks, action)


def servers(gateway: RunningGateway) -> tuple[str, str]:
    state = gateway.http.get("/readyz").json()
    return state["action_server"]["action_name"], state["undock_server"]["action_name"]


def run(gateway: RunningGateway, path: str, body: dict[str, Any] | None = None) -> dict[str, Any]:
    """Send a goal, and wait for its end."""
    answer = gateway.http.post(path, json=body, headers={"Prefer": "wait=60"})
    assert answer.status_code == 200, answer.text
    goal: dict[str, Any] = answer.json()
    return goal


def summary(goal: dict[str, Any]) -> tuple[str, str | None]:
    return goal["status"], goal["error"] and goal["error"]["code"]


def stages(gateway: RunningGateway, goal: dict[str, Any]) -> list[str]:
    events = gateway.http.get(f"/goals/{goal['goal_id']}/history?type=status").json()["events"]
    told = [event["stage"] for event in events if event["stage"] is not None]
    return [stage for index, stage in enumerate(told) if index == 0 or told[index - 1] != stage]


def test_nav2(domain: int, gateway: RunningGateway) -> None:
    with running_servers(domain, "--offer", "nav2", "--docked"):
        wait_until_docked_by(gateway, NAV2)
        assert dock_server(gateway)["action_type"] == "nav2_msgs/action/DockRobot"
        gateway.wait_until_ready()
        wait_until(lambda: servers(gateway) == (NAV2, "/undock_robot"), "both actions")

        undock = run(gateway, "/undock")
        assert summary(undock) == ("aborted", "dock_not_valid")
        assert "dock_type" in undock["error"]["detail"]
        assert summary(run(gateway, "/undock", {"dock_type": "charger"})) == ("succeeded", None)
        assert summary(run(gateway, "/undock", {"dock_type": "charger"})) == ("aborted", "goal_aborted")

        docked = run(gateway, "/dock", {"dock_id": "home"})
        assert summary(docked) == ("succeeded", None)
        assert (docked["verb"], docked["goal"]["dock_id"], docked["goal"]["use_dock_id"]) == ("dock", "home", True)
        way = ["NAV_TO_STAGING_POSE", "INITIAL_PERCEPTION", "CONTROLLING", "WAIT_FOR_CHARGE"]
        assert stages(gateway, docked) == way
        assert docked["feedback"]["state"] == 4
        assert summary(run(gateway, "/undock")) == ("succeeded", None), "the server knows the dock by now"

        wobbly = run(gateway, "/dock", {"desired_battery_state": {"power_supply_status": "FULL", "location": "wobbly"}})
        assert (summary(wobbly), wobbly["retries"]) == (("succeeded", None), 1)
        assert stages(gateway, wobbly) == [*way[:3], "INITIAL_PERCEPTION", *way[2:]]
        listed = gateway.http.get("/dock").json()["goals"]
        assert [goal["goal_id"] for goal in listed] == [wobbly["goal_id"], docked["goal_id"]]


def test_nav2_fails(domain: int, gateway: RunningGateway) -> None:
    codes = {
        "902": "dock_not_valid",
        "903": "failed_to_stage",
        "904": "failed_to_detect_dock",
        "905": "failed_to_control",
        "906": "failed_to_charge",
        "907": "timeout",
        "999": "unknown",
        "12345": "unknown",
        "nowhere": "dock_not_in_db",
    }
    with running_servers(domain, "--offer", "nav2", "--stage-time", "0.05"):
        wait_until_docked_by(gateway, NAV2)
        ended = {dock: run(gateway, "/dock", {"dock_id": dock}) for dock in codes}
        assert {dock: goal["error"]["code"] for dock, goal in ended.items()} == codes
        assert {goal["status"] for goal in ended.values()} == {"aborted"}
        assert ended["904"]["error"]["detail"] == "the dock was not detected: failed with 904"
        assert summary(run(gateway, "/dock")) == ("aborted", "dock_not_in_db"), "an empty body names no dock"
        pose = {"header": {"frame_id": "map"}, "pose": {"position": {"x": 1.0}}}
        by_pose = run(gateway, "/dock", {"dock_pose": pose, "dock_type": "charger"})
        assert (summary(by_pose), by_pose["goal"]["use_dock_id"]) == (("succeeded", None), False)

        for body, path in (
            ({"dock_id": ""}, "dock_id"),
            ({"use_dock_id": False}, "dock_pose"),
            ({"dock": "home"}, "dock"),
            ({"desired_battery_state": {"power_supply_status": 2}}, "desired_battery_state.power_supply_status"),
            ({"desired_battery_state": {"voltage": "high"}}, "desired_battery_state.voltage"),
        ):
            refused = gateway.http.post("/dock", json=body)
            assert (refused.status_code, refused.json()["errors"][0]["path"]) == (422, path)
        assert gateway.http.post("/undock", json={"dock_id": "home"}).status_code == 422

        slow = gateway.http.post("/dock", json={"dock_id": "slow"}).json()
        gateway.wait_for_goal(slow["goal_id"], "executing")
        assert gateway.http.post(f"/dock/{slow['goal_id']}/cancel").status_code == 202
        assert summary(gateway.wait_for_goal(slow["goal_id"], "canceled")) == ("canceled", None)

        slow = gateway.http.post("/dock", json={"dock_id": "slow"}).json()
        gateway.wait_for_goal(slow["goal_id"], "executing")
        gateway.stop_once()
        assert summary(gateway.wait_for_goal(slow["goal_id"], "canceled")) == ("canceled", "stopped")

        slow = gateway.http.post("/dock", json={"dock_id": "slow"}).json()
        gateway.wait_for_goal(slow["goal_id"], "executing")
        assert summary(run(gateway, "/dock", {"dock_id": "home"})) == ("succeeded", None)
        assert summary(gateway.wait_for_goal(slow["goal_id"], "aborted")) == ("aborted", "goal_aborted")


def test_create3(domain: int, gateway: RunningGateway) -> None:
    outcomes = ("missed", "gave-up", "slow")
    with running_servers(domain, "--robot", "/robot3", "--offer", "create3", "--outcomes", *outcomes):
        wait_until(lambda: gateway.http.get("/robots?robot=/robot3").is_success, "the robot")
        wait_until_docked_by(gateway, "/robot3/dock", "/robot3")
        query = "?robot=/robot3"
        for what in ("missed", "gave-up"):
            assert summary(run(gateway, f"/dock{query}")) == ("aborted", "failed_to_dock"), what
        slow = gateway.http.post(f"/dock{query}").json()
        gateway.wait_for_goal(slow["goal_id"], "executing")
        gateway.http.post(f"/dock/{slow['goal_id']}/cancel")
        assert summary(gateway.wait_for_goal(slow["goal_id"], "canceled")) == ("canceled", None)

        docked = run(gateway, f"/dock{query}", {"desired_battery_state": {"power_supply_status": 1}})
        assert (summary(docked), docked["result"]) == (("succeeded", None), {"is_docked": True})
        assert stages(gateway, docked) == ["INITIAL_PERCEPTION", "CONTROLLING"]
        again = gateway.http.post(f"/dock{query}")
        assert (again.status_code, again.json()["code"]) == (409, "goal_rejected")
        refused = gateway.http.post(f"/dock{query}", json={"dock_id": "home"})
        assert (refused.status_code, refused.json()["errors"][0]["path"]) == (422, "dock_id")
        (robot,) = gateway.http.get(f"/robots{query}").json()["robots"]
        assert robot["docked"] is True
        assert summary(run(gateway, f"/undock{query}")) == ("succeeded", None)
        (robot,) = gateway.http.get(f"/robots{query}").json()["robots"]
        assert robot["docked"] is False


def test_who_docks_the_robot(domain: int) -> None:
    """A server that comes later than the gateway, two kinds at once, one that goes."""
    with running_gateway(domain, default_dock="home") as gateway, gateway.stream("?include=system") as stream:
        refused = gateway.http.post("/dock")
        assert (refused.status_code, refused.json()["code"]) == (503, "action_server_unavailable")
        with running_servers(domain, "--offer", "nav2", "create3"):
            wait_until_docked_by(gateway, NAV2)
            told = stream.until(lambda event: event["type"] == "docking" and event["docking"]["dock"]["available"])
            assert told["docking"]["undock"]["action_name"] == "/undock_robot"
            docked = run(gateway, "/dock")
            assert (summary(docked), docked["goal"]["dock_id"]) == (("succeeded", None), "home")
            slow = gateway.http.post("/dock", json={"dock_id": "slow"}).json()
            gateway.wait_for_goal(slow["goal_id"], "executing")
            with running_dock_server(domain):
                stream.until(
                    lambda event: (
                        event["type"] == "action_server"
                        and event["action_server"]["action_name"] == "/connect_to_charging_dock"
                        and event["action_server"]["available"]
                    )
                )
                assert dock_server(gateway)["action_name"] == NAV2, "its goal runs"
                gateway.stop_once()
                wait_until_docked_by(gateway, "/connect_to_charging_dock")
                ours = gateway.http.post("/dock").json()
                assert ours["goal"]["desired_battery_state"]["location"] == "home"
                gateway.stop_once()
            wait_until_docked_by(gateway, NAV2)  # it is there, ours has gone
            listed = gateway.http.get("/dock").json()["goals"]
            assert [goal["action_name"] for goal in listed] == ["/connect_to_charging_dock", NAV2, NAV2]
