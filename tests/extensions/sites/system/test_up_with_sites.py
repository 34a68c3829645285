"""`dock-gateway up --sites 2`, as from a shell: one page for all sites, and nothing is left behind."""

import os
import signal
import socket
from contextlib import suppress
from pathlib import Path

import httpx2
import pytest

from tests.support.processes import BIN, Process, free_port, ros_environment
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros


def session_of(pid: int) -> set[int]:
    """The process and all that it has started."""
    found = {pid}
    while True:
        children = set()
        for each in found:
            with suppress(FileNotFoundError, ProcessLookupError):
                for task in Path(f"/proc/{each}/task").iterdir():
                    children |= set(map(int, task.joinpath("children").read_text().split()))
        if children <= found:
            return found
        found |= children


def is_free(port: int) -> bool:
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", port)) != 0


def free_ports(count: int) -> int:
    """The first of some ports in a row that nobody listens on."""
    while not all(map(is_free, range(first := free_port(), first + count))):
        pass
    return first


def test_two_sites_behind_a_hub(tmp_path: Path) -> None:
    port = free_ports(3)
    # Domains that no other test takes: the two after this one.
    environment = ros_environment(10 + os.getpid() % 4 * 2, TMPDIR=str(tmp_path))
    with Process(str(BIN / "dock-gateway"), "up", "--sites", "2", "--port", str(port), env=environment) as up:
        up.wait_for(f"is ready: open http://127.0.0.1:{port}")
        up.wait_for(f"oslo: http://127.0.0.1:{port + 2}")
        with httpx2.Client(base_url=f"http://127.0.0.1:{port}", trust_env=False, timeout=60) as http:

            def dockable() -> set[str]:
                robots = http.get("/robots").json()["robots"]
                return {robot["name"] for robot in robots if robot["dock"] and robot["dock"]["available"]}

            wait_until(lambda: dockable() == {"/berlin", "/oslo"}, "the robots of both sites")
            sent = http.post("/sites/oslo/dock")
            assert sent.status_code == 202, sent.text
            goal = f"/goals/{sent.json()['goal_id']}"
            wait_until(lambda: http.get(goal).status_code == 200, "the goal at the hub")
            assert http.get(goal).json()["action_name"].startswith("/oslo/")
            own = httpx2.get(f"http://127.0.0.1:{port + 2}{goal}", trust_env=False)
            assert own.json()["goal_id"] == sent.json()["goal_id"]
        everything = session_of(up.pid)
        assert len(everything) > 8
        up.send_signal(signal.SIGINT)
        assert up.wait() == 0
        assert not [pid for pid in everything if Path(f"/proc/{pid}").exists()]
    assert not list(tmp_path.glob("dock-gateway-sites-*"))
    assert "Traceback" not in up.output
