"""Docking and undocking a simulated robot through the gateway alone, with faults and with stops."""

from collections.abc import Iterator
from typing import Any

import pytest

from tests.support.docking import FAST, UNMEASURED
from tests.support.gateway import RunningGateway, Stream, running_gateway, running_program
from tests.support.installed import needs
from tests.support.waiting import wait_until

pytestmark = [needs("simulator"), pytest.mark.ros]

SIMULATOR = ("-p", FAST)
SERVER = ("-p", "controller:=dock_pose", "-p", UNMEASURED, "-p", "wait_charge_timeout:=1.5", "-p", "max_retries:=1")
CHARGING, NOT_CHARGING = 1, (2, 3)


@pytest.fixture(scope="module")
def gateway(shared_domain: int) -> Iterator[RunningGateway]:
    with (
        running_program(shared_domain, "dock_simulator", *SIMULATOR),
        running_program(shared_domain, "docking_server", *SERVER),
        running_gateway(shared_domain) as gateway,
    ):
        gateway.wait_until_ready()
        wait_until(lambda: gateway.http.get("/simulator").status_code == 200, "the simulator")
        yield gateway


@pytest.fixture(autouse=True)
def from_the_start(gateway: RunningGateway) -> Iterator[None]:
    yield
    gateway.http.delete("/stop").raise_for_status()
    gateway.stop_once()
    wait_until(lambda: not running(gateway), "the end of every goal")
    gateway.http.post("/simulator/reset").raise_for_status()


def running(gateway: RunningGateway) -> list[dict[str, Any]]:
    query = "&".join(f"status={status}" for status in ("pending", "accepted", "executing", "canceling"))
    return [goal for verb in ("dock", "undock") for goal in gateway.http.get(f"/{verb}?{query}").json()["goals"]]


def place(gateway: RunningGateway, x: float, y: float, theta: float) -> None:
    """Put the robot somewhere off its dock; the battery knows it once this returns."""
    with gateway.stream("?include=battery") as stream:
        gateway.http.post("/simulator/place", json={"x": x, "y": y, "theta": theta}).raise_for_status()
        for _ in range(3):
            stream.until(
                lambda e: e["type"] == "battery" and e["battery"]["state"]["power_supply_status"] in NOT_CHARGING
            )


def do(gateway: RunningGateway, verb: str) -> dict[str, Any]:
    """Send a goal and wait for its end."""
    headers = {"Prefer": "wait=90"}
    goal: dict[str, Any] = gateway.http.post(f"/{verb}", headers=headers, timeout=100).raise_for_status().json()
    return goal


def test_a_dead_charger_is_the_goals_error(gateway: RunningGateway) -> None:
    place(gateway, -1.0, 0.1, 0.0)
    gateway.set_fault("dead_charger")
    with gateway.stream("?include=cmd_vel,scene") as stream:
        goal_id = gateway.http.post("/dock").raise_for_status().json()["goal_id"]
        planned = stream.until(lambda e: e["type"] == "scene" and e["scene"]["docked"] and e["scene"]["staging"])
        assert planned["scene"]["frame"] == "world"
        assert abs(planned["scene"]["docked"]["x"] + 0.2) < 0.1
        assert abs(planned["scene"]["staging"]["x"] + 0.9) < 0.15
        result = stream.until(lambda e: e["type"] == "result" and e["goal_id"] == goal_id, timeout=120)
        stream.until_zero()
    assert (result["status"], result["error"]["code"]) == ("aborted", "failed_to_charge")
    goal = gateway.goal(goal_id)
    assert goal["error"] == result["error"]
    assert goal["retries"] == 1
    stages = [event["stage"] for event in stream.seen if event["type"] == "status" and event["goal_id"] == goal_id]
    way = {"NAV_TO_STAGING_POSE", "CONTROLLING", "WAIT_FOR_CHARGE", "CORRECTING", "RETRY", "RETURN_TO_STAGING"}
    assert way <= set(stages)
    wait_until(lambda: gateway.http.get("/simulator").json()["contact"] is False, "a robot in front of its dock")


def test_undocking(gateway: RunningGateway) -> None:
    with gateway.stream("?include=battery,system,scene") as stream:
        gateway.http.post("/simulator/place", json={"x": -0.2, "y": 0.0, "theta": 0.0}).raise_for_status()
        stream.until(lambda e: e["type"] == "simulator" and e["simulator"]["docked"])
        stream.until(lambda e: e["type"] == "battery" and e["battery"]["state"]["power_supply_status"] == CHARGING)
        goal = do(gateway, "undock")
        assert (goal["action_name"], goal["verb"]) == ("/disconnect_from_charging_dock", "undock")
        assert goal["status"] == "succeeded"
        assert goal["result"]["final_battery_state"]["power_supply_status"] in NOT_CHARGING
        left = stream.until(lambda e: e["type"] == "simulator" and not e["simulator"]["docked"])["simulator"]
        assert left["contact"] is False
        stream.until(lambda e: e["type"] == "scene" and e["scene"]["robot"]["x"] < -0.6)
    history = f"/goals/{goal['goal_id']}/history"
    poses = gateway.http.get(f"{history}?type=pose").json()["events"]
    scenes = [event["scene"] for event in poses]
    assert {scene["frame"] for scene in scenes} == {"world"}
    assert scenes[-1]["footprint"] == {"radius": 0.15, "points": None}
    first, last = scenes[0]["robot"]["x"], scenes[-1]["robot"]["x"]
    assert -0.6 < first < -0.1, "at its dock"
    assert last < -0.6, "off its dock"
    assert scenes[-1]["dock"] == {"x": 0.0, "y": 0.0, "theta": 0.0}
    slots = [int(event["id"][:20]) for event in poses]
    assert len(set(slots)) == len(slots)
    assert all(slot % 200_000_000 == 0 for slot in slots)
    assert {event["type"] for event in gateway.http.get(history).json()["events"]} == {"status", "feedback", "result"}
    exported = gateway.http.get(f"/goals/{goal['goal_id']}/export").json()["events"]
    assert [event for event in exported if event["type"] == "pose"] == poses
    with gateway.stream(path="/ws") as socket:
        socket.connection.send('{"op": "send_goal", "id": "1", "verb": "undock"}')
        again = socket.next()["goal"]
    assert again["verb"] == "undock"
    assert gateway.wait_for_goal(again["goal_id"], "succeeded", "aborted")["status"] == "succeeded"
    assert [entry["goal_id"] for entry in gateway.http.get("/undock").json()["goals"]][1] == goal["goal_id"]
    assert gateway.http.get(f"/undock/{goal['goal_id']}").json() == gateway.goal(goal["goal_id"])
    again = gateway.http.post(f"/undock/{goal['goal_id']}/cancel")
    assert (again.status_code, again.json()["code"]) == (409, "goal_terminal")


def test_a_stop_on_the_way_holds_until_it_is_released(gateway: RunningGateway) -> None:
    place(gateway, -1.8, 0.3, -0.1)
    with gateway.stream("?include=scene,cmd_vel") as stream:
        goal_id = gateway.http.post("/dock").raise_for_status().json()["goal_id"]
        stream.until(lambda e: e["type"] == "cmd_vel" and e["cmd_vel"]["linear"]["x"] > 0.1)
        assert gateway.http.post("/stop", json={"by": "Ada"}).raise_for_status().json()["stop"]["latched"]
        result = stream.until(lambda e: e["type"] == "result" and e["goal_id"] == goal_id)
        assert result["status"] in ("canceled", "aborted")
        stands_still(stream)
        for verb in ("dock", "undock"):
            refused = gateway.http.post(f"/{verb}")
            assert (refused.status_code, refused.json()["code"]) == (409, "stop_latched")
        gateway.http.delete("/stop").raise_for_status()
        stands_still(stream)  # a release moves nothing
    assert do(gateway, "dock")["status"] == "succeeded"


def stands_still(stream: Stream) -> None:
    """Wait until ten poses in a row are the same."""
    poses: list[dict[str, float]] = []
    while len(poses) < 10 or poses[-10:] != [poses[-1]] * 10:
        poses.append(stream.until_type("scene")["scene"]["robot"])
        assert len(poses) < 100, f"it moves: {poses[-3:]}"
