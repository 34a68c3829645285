"""A recorded goal is replayed: the same course with the same parameters, and another one with others."""

import os
import subprocess
from pathlib import Path

import pytest
from geometry_msgs.msg import Twist
from sensor_msgs.msg import BatteryState

from tests.support.gateway import running_gateway
from tests.support.observer import Observer
from tests.support.processes import BIN, ForkedProcess, ros_environment
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros

DISCHARGING = BatteryState(power_supply_status=BatteryState.POWER_SUPPLY_STATUS_DISCHARGING)
CHARGING = BatteryState(power_supply_status=BatteryState.POWER_SUPPLY_STATUS_CHARGING)


def replay(recording: Path, *arguments: str) -> tuple[int, str]:
    """Return the exit code and the words of a replay."""
    environment = os.environ | {"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"}  # it meets nobody all the same
    command = [str(BIN / "dock-gateway"), "replay", str(recording), *arguments]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    return done.returncode, done.stdout + done.stderr


def test_a_recorded_goal_is_replayed(domain: int, observer: Observer, tmp_path: Path) -> None:
    recordings = str(tmp_path / "recordings")
    server = ("connect_to_charging_dock_server", "--ros-args", "-p", "rotate_speed:=0.25")
    with (
        ForkedProcess(*server, env=ros_environment(domain)),
        running_gateway(domain, record="all", recordings_path=recordings) as gateway,
    ):
        gateway.wait_until_ready()
        with observer.publishing(Twist(), "cmd_vel"):
            wait_until(
                lambda: b"/cmd_vel" in gateway.http.get("/robots/recording.mcap").content, "velocities are recorded"
            )
        with observer.publishing(DISCHARGING, "battery_status"):
            goal_id = gateway.http.post("/dock").raise_for_status().json()["goal_id"]
            wait_until(lambda: gateway.goal(goal_id)["feedback_count"] > 30, "three seconds of turning")
        with observer.publishing(CHARGING, "battery_status"):
            gateway.wait_for_goal(goal_id, "succeeded")
        path = f"/goals/{goal_id}/recording"
        wait_until(lambda: gateway.http.get(path).json()["size"], "the recording")
        recording = tmp_path / "goal.mcap"
        recording.write_bytes(gateway.http.get(f"{path}.mcap").content)

    code, words = replay(recording)
    assert (code, "it takes the same course" in words) == (0, True), words
    code, words = replay(recording, "--ros-args", "-p", "rotate_speed:=0.5")
    assert code == 1, words
    assert "another velocity" in words
    assert "up to 0.00 m/s and 0.50 rad/s, where 0.00 m/s and 0." in words
    (tmp_path / "no.mcap").write_text("no recording")
    code, words = replay(tmp_path / "no.mcap")
    assert (code, "is no recording of a goal" in words) == (2, True), words
