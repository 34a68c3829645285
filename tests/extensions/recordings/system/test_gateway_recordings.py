"""The black box: a goal that fails leaves what was heard of its robot, also if the gateway is killed meanwhile."""

import signal
import time
from pathlib import Path
from typing import Any
from uuid import UUID

import orjson
import pytest
from mcap.reader import make_reader
from nav_msgs.msg import OccupancyGrid
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.serialization import deserialize_message
from rosbags.highlevel import AnyReader
from rosbags.interfaces import QosDurability

from dock_gateway.extensions.recordings.recorder import BEFORE_GOAL
from dock_gateway.ros.messages.interfaces import load_message
from robot_io.recording import Sample, read
from tests.support.gateway import ACTION, RunningGateway, running_gateway
from tests.support.observer import Observer
from tests.support.processes import ForkedProcess, ros_environment
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros

FEEDBACK, EVENTS = f"{ACTION}/_action/feedback", "/dock_gateway/events"
ABORTED, SUCCEEDED = 8, 4


def send(gateway: RunningGateway, status: int) -> str:
    sent = gateway.http.post("/dock", json={"desired_battery_state": {"power_supply_status": status}})
    goal_id: str = sent.raise_for_status().json()["goal_id"]
    return goal_id


def wait_for_recording(gateway: RunningGateway, goal_id: str) -> int:
    path = f"/goals/{goal_id}"
    size: int = wait_until(
        lambda: gateway.http.get(path).raise_for_status().json()["recording"]["size_bytes"], "the recording"
    )
    return size


def download(gateway: RunningGateway, path: str, folder: Path) -> dict[str, list[Any]]:
    """The messages of a recording, by topic."""
    file = folder / "recording.mcap"
    file.write_bytes(gateway.http.get(path).raise_for_status().content)
    messages: dict[str, list[Any]] = {}
    with file.open("rb") as stream:
        for _, channel, message in make_reader(stream).iter_messages():
            decoded = deserialize_message(message.data, load_message(channel.metadata["ros_type"]))
            messages.setdefault(channel.topic, []).append(
                orjson.loads(decoded.data) if channel.topic == EVENTS else decoded
            )
    return messages


def test_a_failed_goal_leaves_a_recording_also_if_the_gateway_is_killed(domain: int, tmp_path: Path) -> None:
    recordings = tmp_path / "recordings"
    kept = {
        "database_url": f"sqlite:///{tmp_path}/history.db",
        "recordings_path": str(recordings),
        "recordings": "failed",
    }
    command = ("-m", "tests.support.plain_action_server", "--feedbacks", "20")
    with ForkedProcess(*command, env=ros_environment(domain)) as server:
        server.wait_for("serving")
        with running_gateway(domain, **kept) as gateway:
            gateway.wait_until_ready()
            succeeded = send(gateway, SUCCEEDED)
            gateway.wait_for_goal(succeeded, "succeeded")
            goal_id = send(gateway, ABORTED)
            size = wait_for_recording(gateway, goal_id)
            check_download(gateway, goal_id, size)
            messages = download(gateway, f"/goals/{goal_id}/recording.mcap", tmp_path)
            of_goal = [each for each in messages[FEEDBACK] if each.goal_id.uuid.tobytes() == UUID(goal_id).bytes]
            heard = [each.feedback.current_battery_state.percentage for each in of_goal]
            assert heard == pytest.approx([count / 100 for count in range(20)])
            events = {(each["type"], each.get("what") or each.get("status")) for each in messages[EVENTS]}
            assert {("command", "dock"), ("status", "aborted")} <= events
            problem = gateway.http.get(f"/goals/{succeeded}/recording.mcap").json()
            assert (problem["code"], "succeeded" in problem["detail"]) == ("recording_not_found", True)
            assert FEEDBACK in download(gateway, "/recording.mcap", tmp_path)
            assert gateway.http.get(f"/goals/{goal_id}/thumbnail").json()["code"] == "picture_not_found"

            interrupted = send(gateway, ABORTED)
            wait_until(lambda: gateway.http.get(f"/goals/{interrupted}").json()["feedback"], "feedback")
            begun = size_of(part := recordings / f"{interrupted}.part")
            wait_until(lambda: size_of(part) > max(begun, 1000), "the beginning of the recording")
            gateway.process.send_signal(signal.SIGKILL)
            gateway.process.wait()
        with running_gateway(domain, **kept) as again:
            again.wait_for_goal(interrupted, "aborted")
            wait_for_recording(again, interrupted)
            messages = download(again, f"/goals/{interrupted}/recording.mcap", tmp_path)
            assert UUID(interrupted).bytes in {each.goal_id.uuid.tobytes() for each in messages[FEEDBACK]}
            known = again.http.get(f"/goals/{goal_id}").json()
            assert known["recording"] == {"state": "complete", "size_bytes": size, "picture": False, "reason": None}
            assert known in again.http.get("/goals").json()["goals"]


def check_download(gateway: RunningGateway, goal_id: str, size: int) -> None:
    """It can be downloaded in ranges, and is not sent again to who has it."""
    path = f"/goals/{goal_id}/recording.mcap"
    head = gateway.http.get(path, headers={"Range": "bytes=0-7"})
    assert (head.status_code, head.content) == (206, b"\x89MCAP0\r\n")
    assert head.headers["content-range"] == f"bytes 0-7/{size}"
    for odd in ("bytes=900000000-", "bytes=9-1", "lines=1-2"):
        assert gateway.http.get(path, headers={"Range": odd}).status_code == 422
    assert gateway.http.get(path, headers={"If-None-Match": head.headers["etag"]}).status_code == 304


def size_of(path: Path) -> int:
    return path.stat().st_size if path.exists() else 0


def test_what_was_published_once_long_before_is_the_first_in_the_recording(
    domain: int, observer: Observer, tmp_path: Path
) -> None:
    """A map and transforms hold until the next ones: `ros2 bag play` publishes them first, for who comes later, too."""
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    the_map = OccupancyGrid(data=[100] * 50)
    publisher = observer.call(lambda: observer.node.create_publisher(OccupancyGrid, "/map", latched))
    publisher.publish(the_map)
    command = ("-m", "tests.support.plain_action_server", "--feedbacks", "5")
    with (
        ForkedProcess(*command, env=ros_environment(domain)) as server,
        running_gateway(domain, recordings="all", recording_topics="/map") as gateway,
    ):
        server.wait_for("serving")
        gateway.wait_until_ready()
        file = tmp_path / "recording.mcap"

        def recorded(path: str) -> list[Sample]:
            answer = gateway.http.get(path)
            if answer.status_code == 404:  # nothing has been heard yet
                return []
            file.write_bytes(answer.raise_for_status().content)
            return [each for each in read(file) if each.topic == "/map"]

        (heard, *_) = wait_until(lambda: recorded("/recording.mcap"), "the map")
        old_ns = heard.received_ns + (BEFORE_GOAL + 0.5) * 1e9
        wait_until(lambda: time.time_ns() > old_ns, "it is older than what a recording has of before its goal")
        goal_id = send(gateway, SUCCEEDED)
        wait_for_recording(gateway, goal_id)
        (found,) = recorded(f"/goals/{goal_id}/recording.mcap")
    assert deserialize_message(found.data, OccupancyGrid) == the_map
    samples = list(read(file))
    assert found.received_ns == min(each.received_ns for each in samples)
    assert found.received_ns > heard.received_ns
    with AnyReader([file]) as reader:
        first, at, _ = next(iter(reader.messages()))
        offered = {each.topic: each.ext.offered_qos_profiles for each in reader.connections}  # type: ignore[union-attr]
        assert (first.topic, at) == ("/map", reader.start_time)
    assert [each.durability for each in offered["/map"]] == [QosDurability.TRANSIENT_LOCAL]
    assert [each.durability for each in offered[f"{ACTION}/_action/status"]] == [QosDurability.TRANSIENT_LOCAL]
    assert [each.durability for each in offered[FEEDBACK]] == [QosDurability.VOLATILE]
