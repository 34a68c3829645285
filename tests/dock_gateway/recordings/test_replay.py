"""What the replay of a goal shows of its recording."""

import math
from pathlib import Path
from typing import Any

import pytest
from geometry_msgs.msg import TransformStamped, Twist, TwistStamped
from nav_msgs.msg import Odometry
from rclpy.serialization import serialize_message
from sensor_msgs.msg import BatteryState, LaserScan

from dock_gateway.recordings.mcap_file import McapFile
from dock_gateway.recordings.replay import Replay
from dock_gateway.ros.messages.types import type_name
from robot_io.recording import Sample
from tf2_msgs.msg import TFMessage

BEGAN = 1_000_000_000_000
SCAN = LaserScan(angle_min=0.0, angle_increment=math.pi / 2, range_max=10.0, ranges=[2.0, math.inf])
SCAN.header.frame_id = "laser"


def sample(topic: str, message: Any, seconds: float) -> Sample:
    at = BEGAN + round(seconds * 1e9)
    return Sample(topic, type_name(type(message)), serialize_message(message), at, at)


def laser_at(x: float, y: float) -> Sample:
    stamped = TransformStamped(child_frame_id="laser")
    stamped.header.frame_id = "base"
    stamped.transform.translation.x, stamped.transform.translation.y = x, y
    return sample("/tf_static", TFMessage(transforms=[stamped]), -5)


def replay(path: Path, *samples: Sample) -> dict[str, Any]:
    with path.open("wb") as output:
        file = McapFile(output)
        file.write(samples)
        file.finish({})
    return Replay(BEGAN, "cmd_vel").read(path, lambda topic: topic != "/secret/battery")


def test_scans_velocities_and_battery_as_seen_from_the_robot(tmp_path: Path) -> None:
    twist = Twist()
    twist.linear.x = 0.25
    found = replay(
        tmp_path / "goal.mcap",
        laser_at(0.5, 0.0),
        sample("/robot1/odom", Odometry(child_frame_id="base"), -4),
        sample("/secret/battery", BatteryState(voltage=1.0), 0),
        *(sample("/robot1/scan", SCAN, at) for at in (-4, 0, 0.05, 1)),
        *(sample("/robot1/other_scan", SCAN, at) for at in (0, 1)),
        sample("/robot1/cmd_vel", twist, 1),
        sample("/robot1/cmd_vel_raw", twist, 1),
        sample("/robot1/battery_status", BatteryState(voltage=8.0, percentage=math.nan), 2),
    )
    assert found["scans"] == [{"at": 0.0, "points": [[2.5, 0.0]]}, {"at": 1.0, "points": [[2.5, 0.0]]}]
    assert found["velocity"] == [{"at": 1.0, "linear": 0.25, "angular": 0.0}]
    assert found["battery"] == [{"at": 2.0, "voltage": 8.0, "percentage": pytest.approx(math.nan, nan_ok=True)}]


def test_what_makes_no_sense_is_left_out(tmp_path: Path) -> None:
    odd = LaserScan(angle_increment=math.nan, ranges=[1.0])
    damaged = Sample("/robot1/scan", type_name(LaserScan), b"\0\1\0\0odd", BEGAN, BEGAN)
    found = replay(
        tmp_path / "goal.mcap",
        laser_at(math.inf, 0.0),
        damaged,
        sample("/robot1/scan", odd, 1),
        sample("/robot1/scan", SCAN, 2),
        sample("/robot1/cmd_vel", TwistStamped(), 3),
    )
    assert found == {"scans": [], "velocity": [{"at": 3.0, "linear": 0.0, "angular": 0.0}], "battery": []}
