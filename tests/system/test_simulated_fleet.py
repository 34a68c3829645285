"""Many simulated robots in one hall, each a fork of one process."""

import os
import signal
import sys
from pathlib import Path

import pytest

from docking.nodes.simulated_fleet import main
from tests.support.gateway import running_gateway
from tests.support.installed import needs
from tests.support.processes import ForkedProcess, Process, ros_environment
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros


def children(parent: int) -> list[int]:
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = stat.read_text().rpartition(")")[2].split()
        except (FileNotFoundError, ProcessLookupError):  # it has just ended
            continue
        if int(fields[1]) == parent:
            found.append(int(stat.parent.name))
    return sorted(found)


def alive(pid: int) -> bool:
    return Path(f"/proc/{pid}").exists()


def test_robots_that_are_started_again_and_end_together(domain: int) -> None:
    command = (sys.executable, "-m", "docking.nodes.simulated_fleet", "2")
    with Process(*command, env=ros_environment(domain)) as fleet:
        for robot in (1, 2):
            fleet.wait_for(f"[robot{robot}.dock_simulator]: Simulating a robot")
        first, second = children(fleet.pid)
        os.kill(first, signal.SIGKILL)
        fleet.wait_for("ended (-9); starting it again")
        wait_until(lambda: len(set(children(fleet.pid)) - {first, second}) == 1, "a new robot")
        wait_until(lambda: fleet.output.count("Simulating a robot") == 3, "its simulator")
        robots = children(fleet.pid)
        fleet.send_signal(signal.SIGTERM)
        assert fleet.wait() == 0
        assert not any(map(alive, robots))
        assert "Traceback" not in fleet.output


@pytest.mark.parametrize("given", [["3", "--docks", "0"], ["3", "--docks", "4"], ["0"], ["many"]])
def test_halls_that_cannot_be(given: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(given)
    assert ended.value.code == 2
    assert "error: " in capsys.readouterr().err


@needs("simulator", "maps")
def test_two_robots_share_a_hall_and_its_dock(domain: int) -> None:
    """The second one waits before the dock while the first one stands there, without a bump, and docks then."""
    first, second = {"robot": "/robot1"}, {"robot": "/robot2"}
    command = ("-m", "docking.nodes.simulated_fleet", "2", "--docks", "1")
    with running_gateway(domain, namespace="/robot1") as gateway, ForkedProcess(*command, env=ros_environment(domain)):
        http = gateway.http
        for at in (first, second):
            wait_until(lambda at=at: http.get("/simulator", params=at).status_code == 200, "a simulator")
            wait_until(lambda at=at: http.get("/docks", params=at).status_code == 200, "its docking server")
            (dock,) = http.get("/docks", params=at).json()["docks"]
            assert (dock["dock_id"], dock["frame"], dock["pose"]["x"]) == ("dock1", "map", -0.2)
            wait_until(lambda at=at: http.get("/map", params=at).json().get("odom"), "where odometry is on the map")
            assert http.get("/map", params=at).json()["topic"] == "/map"

        # Each on its own way, and then the first one on the dock.
        goal = http.post("/dock", params=first, json={"dock_id": "dock1"}, headers={"Prefer": "wait=120"}, timeout=130)
        assert goal.json()["status"] == "succeeded", goal.json()["error"]
        waiting = http.post("/dock", params=second).json()["goal_id"]
        wait_until(lambda: gateway.goal(waiting)["stage"] == "WAIT_FOR_CLEARANCE", "the second robot waits", 60)
        assert http.get("/simulator", params=first).json()["docked"]
        http.post("/simulator/place", params=first, json={"x": -4.0, "y": 2.0, "theta": 0.0}).raise_for_status()
        assert gateway.wait_for_goal(waiting, "succeeded", "aborted", timeout=120)["error"] is None
        assert http.get("/simulator", params=second).json()["docked"]
        assert not http.get("/simulator", params=first).json()["docked"]
