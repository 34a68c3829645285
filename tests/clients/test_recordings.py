"""The recording of a docking, read by others: every message by mcap-ros2-support, and by @mcap/core with @foxglove."""

import json
import math
import os
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest
from rclpy.serialization import deserialize_message

from dock_gateway.ros.messages.codec import codec
from dock_gateway.ros.messages.interfaces import load_message
from robot_io.recording import EVENTS, read
from tests.clients.installed import CLIENTS, HERE
from tests.support.domain import ros_domain
from tests.support.gateway import ACTION, running_gateway, running_program
from tests.support.installed import needs
from tests.support.waiting import wait_until

pytestmark = needs("recordings")

Messages = dict[str, list[Any]]


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """What a robot with its dock leaves that docks, with a camera and laser, and transforms."""
    file = tmp_path_factory.mktemp("recording") / "goal.mcap"
    with ros_domain() as domain, ExitStack() as stack:
        stack.enter_context(running_program(domain, "dock_simulator"))
        stack.enter_context(running_program(domain, "docking_server", "-p", "controller:=dock_pose"))
        gateway = stack.enter_context(running_gateway(domain, recordings="all"))
        wait_until(lambda: "/scan" in gateway.http.get("/graph").text, "the robot")
        gateway.wait_until_ready()
        goal_id = gateway.http.post("/dock").raise_for_status().json()["goal_id"]
        gateway.wait_for_goal(goal_id, "succeeded")
        path = f"/goals/{goal_id}"
        wait_until(lambda: gateway.http.get(path).raise_for_status().json()["recording"]["size"], "the recording")
        file.write_bytes(gateway.http.get(f"{path}.mcap").raise_for_status().content)
        yield file


def decoded(*command: str | Path) -> Messages:
    environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    messages: Messages = json.loads(done.stdout)
    return messages


def ours(recording: Path) -> Messages:
    """As ROS reads them."""
    messages: Messages = {}
    for sample in read(recording):
        kind = load_message(sample.kind)
        text = codec(kind).encode(deserialize_message(sample.data, kind))
        messages.setdefault(sample.topic, []).append(json.loads(text))
    return messages


def is_like(one: Any, other: Any) -> bool:
    """Whether both are the same but for the digits that `float32` does not have."""
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(is_like(value, other[name]) for name, value in one.items())
    if isinstance(one, list):
        return all(is_like(*pair) for pair in zip(one, other, strict=True))
    return math.isclose(one, other, rel_tol=1e-6) if isinstance(one, float) and other is not None else one == other


def test_every_message_is_read_by_others_as_by_ros(recording: Path) -> None:
    python = decoded(CLIENTS / "mcap/bin/python", HERE / "decode.py", recording)
    node = decoded(shutil.which("node") or "node", HERE / "decode.mjs", CLIENTS / "mcap", recording)
    expected = ours(recording)
    assert {topic: len(messages) for topic, messages in python.items()} == {
        topic: len(messages) for topic, messages in node.items()
    }
    assert python == node
    assert python.keys() == expected.keys()
    for topic, messages in expected.items():
        assert is_like(python[topic], messages), topic
    sensors = {"/scan", "/odom", "/tf", "/tf_static", "/detected_dock_pose", "/battery_status", "/cmd_vel"}
    assert sensors | {f"{ACTION}/_action/feedback", f"{ACTION}/_action/status"} <= python.keys()
    events = [json.loads(each["data"]) for each in python[EVENTS]]
    statuses = [each["status"] for each in events if each["type"] == "status"]
    assert (statuses[0], statuses[-1]) == ("pending", "succeeded")
