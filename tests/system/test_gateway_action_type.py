"""An action server is killed in the middle of a goal, and one of the same name and another type takes its place."""

import signal
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from tests.support.gateway import RunningGateway, running_gateway
from tests.support.processes import ForkedProcess, Process, ros_environment
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros

OLD, NEW = "Fibonacci", "ConnectToChargingDock"


@contextmanager
def spin_server(domain: int, kind: str, seconds: str) -> Iterator[Process]:
    with ForkedProcess("-m", "tests.support.spin_server", kind, seconds, env=ros_environment(domain)) as process:
        process.wait_for("serving")
        yield process


def type_of(gateway: RunningGateway) -> str:
    return str(gateway.http.get("/actions/spin").json().get("action_type", "")).rpartition("/")[2]


def test_goals_of_the_old_type_are_lost_and_later_ones_are_of_the_new_type(domain: int) -> None:
    with running_gateway(domain) as gateway:
        with spin_server(domain, OLD, "100") as old:
            wait_until(lambda: type_of(gateway) == OLD, "the action")
            goal_id = gateway.http.post("/actions/spin/goals", json={"order": 3}).raise_for_status().json()["goal_id"]
            old.send_signal(signal.SIGKILL)
            old.wait()
        with spin_server(domain, NEW, "0"):
            wait_until(lambda: type_of(gateway) == NEW, "the new type", 60)
            later = gateway.http.post("/actions/spin/goals", json={}, headers={"Prefer": "wait=10"})
            assert (later.status_code, later.json()["status"]) == (200, "succeeded")
            refused = gateway.http.post("/actions/spin/goals", json={"order": 3})
            assert (refused.status_code, refused.json()["code"]) == (422, "invalid_field")
            lost = gateway.goal(goal_id)
            assert (lost["status"], lost["error"]["code"]) == ("lost", "action_server_lost")
            assert lost["action_type"].endswith(OLD)
            assert gateway.http.post(f"/goals/{goal_id}/cancel").status_code in (202, 409)
            line = gateway.process.wait_for("action /spin was of type")
            assert f"/{OLD}, and is now of type action_tutorials_interfaces/action/{NEW}" in line
