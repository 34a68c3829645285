"""`GET /docks`: the docks of our own server and of nav2's, read over real DDS."""

import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from tests.support.gateway import RunningGateway, running_gateway, running_program
from tests.support.processes import ForkedProcess, ros_environment
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros

DOCKS = """
docks:
  home: {type: wall, frame: map, pose: [1, 2.5, 0.5], id: 7}
  lab: {}
"""
HOME = {"dock_id": "home", "type": "wall", "frame": "map", "pose": {"x": 1.0, "y": 2.5, "theta": 0.5}, "tag_id": "7"}
LAB = {"dock_id": "lab", "type": None, "frame": "map", "pose": None, "tag_id": None}
BATTERY = {"state": {"power_supply_status": 3, "percentage": 0.2, "voltage": 8.4}, "rate_hz": 5.0}


@pytest.fixture
def gateway(domain: int) -> Iterator[RunningGateway]:
    with running_gateway(domain) as gateway:
        yield gateway


@contextmanager
def nav2(domain: int, *arguments: str) -> Iterator[None]:
    pytest.importorskip("nav2_msgs", reason="`make test` installs the interface packages of tests/interfaces")
    command = ("-m", "tests.support.docking_servers", "--offer", "nav2", *arguments)
    with ForkedProcess(*command, env=ros_environment(domain)) as process:
        process.wait_for("serving")
        yield


def docks(gateway: RunningGateway) -> dict[str, Any]:
    answer = gateway.http.get("/docks")
    document: dict[str, Any] = answer.json() | {"status_code": answer.status_code}
    return document


def test_our_own_server(domain: int, gateway: RunningGateway, tmp_path: Path) -> None:
    assert docks(gateway)["status_code"] in (404, 503)  # no server yet
    path = tmp_path / "docks.yaml"
    path.write_text(DOCKS)
    parameters = ("-p", f"dock_database:={path}", "-p", "dock_plugins:=[wall]")
    with running_program(domain, "docking_server", *parameters) as server:
        gateway.wait_until_ready()
        assert docks(gateway) == {
            "status_code": 200,
            "node": "/connect_to_charging_dock_action_server",
            "dock_database": str(path),
            "default": "home",
            "docks": [HOME, LAB],
        }
        gateway.http.put("/battery/publisher", json=BATTERY).raise_for_status()
        refused = gateway.http.post("/dock", json={"dock_id": "nope"})
        assert (refused.status_code, refused.json()["code"]) == (404, "dock_not_found")
        assert (refused.json()["docks"], "goal_id" in refused.json()) == (["home", "lab"], False)
        refused = gateway.http.post("/dock", json={"desired_battery_state": {"location": "nope"}})
        assert (refused.status_code, refused.json()["code"]) == (409, "goal_rejected")
        assert "there is no dock 'nope', but: home, lab" in refused.json()["detail"]
        goal = gateway.http.post("/dock", json={"dock_id": "lab"})
        assert goal.status_code == 202, goal.text
        gateway.http.post(f"/dock/{goal.json()['goal_id']}/cancel").raise_for_status()

        somewhere = {"header": {"frame_id": "map"}, "pose": {"position": {"x": 4.2}}}
        refused = gateway.http.post("/dock", json={"dock_pose": somewhere, "dock_type": "pallet"})
        assert (refused.status_code, refused.json()["code"]) == (409, "goal_rejected")
        assert "the type of the dock is 'pallet', but must be one of dock_plugins (there: wall)" in refused.text
        goal = gateway.http.post("/dock", json={"dock_pose": somewhere, "dock_type": "wall"})
        assert goal.status_code == 202, goal.text
        gateway.http.post(f"/dock/{goal.json()['goal_id']}/cancel").raise_for_status()
        for wrong in ({"header": {"frame_id": 7}}, {"header": {"frame_id": ""}}, 7):
            assert gateway.http.post("/dock", json={"dock_pose": wrong}).status_code == 422

        server.send_signal(signal.SIGSTOP)
        try:
            started = time.monotonic()
            wait_until(lambda: docks(gateway)["status_code"] == 503, "the end of the answer's freshness")
            assert docks(gateway)["code"] == "docks_unavailable"
            assert time.monotonic() - started < 30.0
        finally:
            server.send_signal(signal.SIGCONT)
        wait_until(lambda: docks(gateway).get("docks") == [HOME, LAB], "the docks again")


def test_a_server_without_docks(domain: int, gateway: RunningGateway) -> None:
    with running_program(domain, "docking_server"):
        gateway.wait_until_ready()
        found = docks(gateway)
        assert (found["status_code"], found["docks"], found["default"], found["dock_database"]) == (200, [], None, None)
        gateway.http.put("/battery/publisher", json=BATTERY).raise_for_status()
        refused = gateway.http.post("/dock", json={"dock_id": "lab"})
        assert (refused.status_code, refused.json()["code"], refused.json()["docks"]) == (404, "dock_not_found", [])
        assert gateway.http.get("/goals").json()["goals"] == []
        for known in ({"dock_id": "nearest"}, {"desired_battery_state": {"location": "lab"}}):
            sent = gateway.http.post("/dock", json=known)
            assert sent.status_code == 202, sent.text
            gateway.http.post(f"/goals/{sent.json()['goal_id']}/cancel").raise_for_status()
            wait_until(lambda: not gateway.http.get("/robots").json()["robots"][0]["goals"], "the end of the goal")
        unknown = gateway.http.post("/dock", json={"dok_id": "lab"}).json()["errors"][0]
        assert unknown["expected"].startswith("one of dock_id, ")
        assert unknown["expected"].endswith("desired_battery_state")


def test_nav2(domain: int, gateway: RunningGateway) -> None:
    with nav2(domain, "--docks", "home", "lab"):
        wait_until(lambda: docks(gateway)["status_code"] == 200, "the server")
        home = HOME | {"type": "charger", "tag_id": None}
        lab = {"dock_id": "lab", "type": "charger", "frame": "map", "pose": home["pose"], "tag_id": None}
        assert docks(gateway) == {
            "status_code": 200,
            "node": "/docking_server",
            "dock_database": None,
            "default": None,
            "docks": [home, lab],
        }
