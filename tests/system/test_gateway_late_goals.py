"""Goals that are on their way to an action server when a stop comes are canceled, however late it accepts them."""

import signal
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import httpx2
import pytest

from tests.support.gateway import RunningGateway, running_gateway
from tests.support.processes import ForkedProcess, Process, ros_environment
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros

GOALS = 6
PATH = "/actions/fibonacci/goals"


@contextmanager
def running_server(domain: int, executed: Path, *more: str) -> Iterator[Process]:
    command = ("-m", "tests.support.busy_action_server", "--executed", str(executed), "--seconds", "30", *more)
    with ForkedProcess(*command, env=ros_environment(domain)) as process:
        process.wait_for("serving")
        yield process


def goals(gateway: RunningGateway) -> list[dict[str, Any]]:
    listed: list[dict[str, Any]] = gateway.http.get(PATH).raise_for_status().json()["goals"]
    return listed


def warm_up(gateway: RunningGateway) -> None:
    """Wait until the server is known to take a goal and to cancel it."""
    wait_until(lambda: gateway.http.get("/actions/fibonacci").status_code == 200, "the action")
    goal_id = gateway.http.post(PATH, json={"order": 0}).raise_for_status().json()["goal_id"]
    gateway.http.post(f"/goals/{goal_id}/cancel").raise_for_status()
    gateway.wait_for_goal(goal_id, "canceled")


def sent_to_frozen(gateway: RunningGateway, server: Process, pool: ThreadPoolExecutor) -> list[Any]:
    """Send goals to a server that has just been frozen."""
    server.send_signal(signal.SIGSTOP)
    answers = [pool.submit(post, gateway, number) for number in range(1, GOALS + 1)]
    wait_until(lambda: len(goals(gateway)) == GOALS + 1, "the goals are on their way")
    return answers


def post(gateway: RunningGateway, number: int) -> int:
    return httpx2.post(f"{gateway.url}{PATH}", json={"order": number}, timeout=60, trust_env=False).status_code


@pytest.mark.parametrize(
    ("body", "released", "accept_timeout"),
    [({}, False, "60"), ({}, True, "60"), ({"latch": False}, False, "60"), ({"latch": False}, False, "0.5")],
    ids=["latched", "released", "not latched", "given up"],
)
def test_goals_on_their_way(
    domain: int, tmp_path: Path, body: dict[str, Any], released: bool, accept_timeout: str
) -> None:
    executed = tmp_path / "executed"
    with (
        running_server(domain, executed, "--cancelable") as server,
        running_gateway(domain, accept_timeout=accept_timeout) as gateway,
        ThreadPoolExecutor(GOALS) as pool,
    ):
        warm_up(gateway)
        answers = sent_to_frozen(gateway, server, pool)
        gateway.http.post("/stop", json=body).raise_for_status()
        if released:
            gateway.http.delete("/stop").raise_for_status()
        if accept_timeout == "0.5":
            assert {answer.result() for answer in answers} <= {504, 409}  # 409: it had not been sent when the stop came
        server.send_signal(signal.SIGCONT)
        ended = [gateway.wait_for_goal(goal["goal_id"], "canceled", "rejected") for goal in goals(gateway)]
        canceled = [goal for goal in ended[:GOALS] if goal["status"] == "canceled"]
        assert canceled, "the others had not been sent when the stop came"
        assert {goal["error"]["code"] for goal in ended[:GOALS]} <= {"stopped", "action_server_timeout"}
        if not body:
            gateway.http.delete("/stop").raise_for_status()
        goal_id = gateway.http.post(PATH, json={"order": 99}).raise_for_status().json()["goal_id"]
        gateway.wait_for_goal(goal_id, "executing")


def test_goals_on_their_way_when_the_gateway_restarts(domain: int, tmp_path: Path) -> None:
    kept = {"database_url": f"sqlite:///{tmp_path}/history.db", "stop_path": f"{tmp_path}/stops.json"}
    with running_server(domain, tmp_path / "executed", "--cancelable") as server:
        with running_gateway(domain, **kept) as gateway, ThreadPoolExecutor(GOALS) as pool:
            warm_up(gateway)
            sent_to_frozen(gateway, server, pool)
            gateway.http.post("/stop").raise_for_status()
            gateway.wait_until_stored()
            gateway.process.send_signal(signal.SIGTERM)
            gateway.process.wait()
        with running_gateway(domain, **kept) as gateway:
            gateway.http.delete("/stop").raise_for_status()
            server.send_signal(signal.SIGCONT)
            # With its client gone, the server may take none of the requests: then a goal is lost.
            for goal in goals(gateway):
                gateway.wait_for_goal(goal["goal_id"], "canceled", "lost", "rejected")
            goal_id = gateway.http.post(PATH, json={"order": 99}).raise_for_status().json()["goal_id"]
            gateway.wait_for_goal(goal_id, "executing")
            assert {goal["status"] for goal in goals(gateway)[1:]} <= {"canceled", "lost", "rejected"}
