"""What a real gateway logs, as JSON and for people."""

import json
import os
import signal
from typing import Any

import pytest

from dock_gateway.doctor.environment import describe_ros
from tests.support.gateway import CHARGING, LOW, RunningGateway, ready_gateway, running_dock_server, running_gateway
from tests.support.processes import Process

pytestmark = pytest.mark.ros


def dock(gateway: RunningGateway, request_id: str) -> str:
    """Run a goal to its end; return its id."""
    gateway.wait_until_ready()
    gateway.publish(LOW)
    answer = gateway.http.post("/dock", headers={"X-Request-ID": request_id}).raise_for_status()
    assert answer.headers["x-request-id"] == request_id
    goal_id: str = answer.json()["goal_id"]
    gateway.publish(CHARGING)
    gateway.wait_for_goal(goal_id, "succeeded")
    gateway.process.wait_for(f"goal {goal_id} succeeded")
    return goal_id


def parsed(process: Process) -> list[dict[str, Any]]:
    lines = [json.loads(line) for line in process.own_lines]
    assert all({"time", "level", "logger", "message"} <= line.keys() for line in lines)
    return lines


def test_every_line_is_json(domain: int) -> None:
    with running_dock_server(domain), running_gateway(domain, "env", log_format="json", log_level="debug") as gateway:
        goal_id = dock(gateway, "job-17")
        with gateway.stream(path="/ws") as socket:
            socket.connection.send('{"op": "stop", "latch": false}')
            socket.next()
        gateway.process.send_signal(signal.SIGTERM)
        gateway.process.wait()
        lines = parsed(gateway.process)
    about = [line for line in lines if line.get("goal_id") == goal_id]
    assert [line["message"].split(",")[0] for line in about if line["logger"].endswith("goal_machine")] == [
        f"goal {goal_id} on /connect_to_charging_dock",
        f"goal {goal_id} succeeded",
    ]
    assert about[0]["request_id"] == "job-17"
    assert {line["logger"].partition(".")[0] for line in lines} >= {"dock_gateway"}
    accessed = next(line for line in lines if line["logger"] == "uvicorn.access" and '"POST /dock' in line["message"])
    assert accessed["request_id"] == "job-17"


def test_commands_have_the_id_of_their_handshake(shared_domain: int) -> None:
    headers = {"X-Request-ID": "console-3"}
    with ready_gateway(shared_domain, log_format="json") as gateway:
        gateway.publish(LOW)
        with gateway.stream(path="/ws", headers=headers) as socket:
            assert socket.connection.response is not None
            assert socket.connection.response.headers["x-request-id"] == "console-3"
            socket.connection.send('{"op": "send_goal", "id": "1"}')
            goal_id = socket.next()["goal"]["goal_id"]
        line = json.loads(gateway.process.wait_for(f"goal {goal_id} on "))
        assert (line["request_id"], line["goal_id"]) == ("console-3", goal_id)
        gateway.stop_once()


def test_lines_for_people(shared_domain: int) -> None:
    with running_dock_server(shared_domain), running_gateway(shared_domain) as gateway:
        goal_id = dock(gateway, "job-17")
        line = gateway.process.wait_for(f"goal {goal_id} on ")
    assert line.startswith("[INFO] [20")
    assert gateway.process.wait_for(" with rmw_").endswith(f"cli.gateway]: {describe_ros(os.environ)}")
    assert line.endswith("goal_machine]: " + f"goal {goal_id} on /connect_to_charging_dock, pending, origin gateway")
    others = [line for line in gateway.process.own_lines if "[dock_gateway.audit]" not in line]
    assert not any("job-17" in line for line in others)  # only records of the audit log name the request
