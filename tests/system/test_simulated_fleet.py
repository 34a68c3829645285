"""Many simulated robots, each a fork of one process."""

import os
import signal
import sys
from pathlib import Path

import pytest

from tests.support.processes import Process, ros_environment
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
