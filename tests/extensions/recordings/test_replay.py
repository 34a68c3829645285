"""What the replay of a goal shows of its recording."""

import asyncio
import math
import shutil
from contextlib import suppress
from itertools import pairwise
from pathlib import Path
from typing import Any
from uuid import UUID

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import TransformStamped, Twist, TwistStamped
from hypothesis import given
from hypothesis import strategies as st
from nav_msgs.msg import Odometry
from rcl_interfaces.msg import Log
from rclpy.serialization import serialize_message
from sensor_msgs.msg import BatteryState, CompressedImage, LaserScan

from dock_gateway.core.errors import NotFound
from dock_gateway.core.grant import UNLIMITED
from dock_gateway.extensions.recordings import replay as module
from dock_gateway.extensions.recordings.goal_log import MOST_LINES, MOST_TEXT
from dock_gateway.extensions.recordings.mcap_file import McapFile
from dock_gateway.extensions.recordings.recordings import Recordings
from dock_gateway.extensions.recordings.replay import MOST, Replay, thinned
from dock_gateway.extensions.recordings.store import Recording, RecordingStore
from dock_gateway.extensions.recordings.topics import CAMERA
from dock_gateway.http.requests import json_response
from dock_gateway.ros.messages.types import type_name
from robot_io.recording import Sample, event_sample
from tests.support.odd_recordings import as_file, damaged, odd_samples
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
    return Replay(BEGAN, "cmd_vel", "/robot1").read(path, lambda topic: topic != "/secret/battery")


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
    assert found["scans"] == [{"offset_s": 0.0, "points": [[2.5, 0.0]]}, {"offset_s": 1.0, "points": [[2.5, 0.0]]}]
    assert found["velocity"] == [{"offset_s": 1.0, "linear": 0.25, "angular": 0.0}]
    assert found["battery"] == [{"offset_s": 2.0, "voltage": 8.0, "percentage": pytest.approx(math.nan, nan_ok=True)}]


def line(name: str, text: str, at: float, level: Any = Log.INFO) -> Sample:
    return sample("/rosout", Log(level=level, name=name, msg=text), at)


def diagnosis(level: bytes, at: float, name: str = "robot1/base", topic: str = "/diagnostics") -> Sample:
    status = DiagnosticStatus(level=level, name=name, message=f"as bad as {level[0]}")
    return sample(topic, DiagnosticArray(status=[status]), at)


def test_what_the_nodes_of_the_robot_logged_and_diagnosed_meanwhile(tmp_path: Path) -> None:
    found = replay(
        tmp_path / "goal.mcap",
        line("robot1.docking_server", "before", -1),
        diagnosis(DiagnosticStatus.OK, -1),
        line("robot1.docking_server", "Docking", 0.5),
        line("robot1.docking_server", "too much", 0.6, Log.DEBUG),
        line("robot2.docking_server", "of another robot", 0.7),
        line("robot10.docking_server", "of another robot", 0.7),
        diagnosis(DiagnosticStatus.WARN, 1),
        diagnosis(DiagnosticStatus.WARN, 1.1),
        diagnosis(DiagnosticStatus.ERROR, 1.2, "robot2/base"),
        diagnosis(DiagnosticStatus.OK, 2, "base", "/robot1/diagnostics"),
        diagnosis(DiagnosticStatus.ERROR, 2, "base", "/robot1/diagnostics"),
        line("robot1.base", "x" * 9999, 3, Log.FATAL),
        diagnosis(DiagnosticStatus.OK, 4),
    )
    assert [(each["offset_s"], each["level"], each["node"], each["text"][:20]) for each in found["log"]] == [
        (0.5, "info", "robot1.docking_server", "Docking"),
        (1.0, "warning", "robot1/base", "as bad as 1"),
        (2.0, "error", "base", "as bad as 2"),
        (3.0, "fatal", "robot1.base", 20 * "x"),
        (4.0, "info", "robot1/base", "as bad as 0"),
    ]
    assert len(found["log"][3]["text"]) == MOST_TEXT


def test_of_a_log_that_is_too_long_warnings_and_the_last_lines_are_kept(tmp_path: Path) -> None:
    warnings = (line("robot1.a", "hot", at, Log.WARN) for at in range(10))
    many = (line("robot1.a", str(number), 20 + number / 100) for number in range(2 * MOST_LINES))
    log = replay(tmp_path / "goal.mcap", *warnings, *many)["log"]
    assert len(log) == MOST_LINES
    assert [each["level"] for each in log[:11]] == [*10 * ["warning"], "info"]
    assert log[-1]["text"] == str(2 * MOST_LINES - 1)


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
    velocity = [{"offset_s": 3.0, "linear": 0.0, "angular": 0.0}]
    assert found == {"scans": [], "velocity": velocity, "battery": [], "log": []}


def test_of_two_lasers_on_one_topic_that_take_turns_one_is_seen(tmp_path: Path) -> None:
    """Whichever comes first: what shows nothing does not count as a message that was used."""
    dark, lost = LaserScan(angle_increment=0.1, range_max=10.0, ranges=[math.inf]), LaserScan(ranges=[1.0])
    dark.header.frame_id, lost.header.frame_id = "laser", "nowhere"
    for other in (dark, lost):
        scans = [sample("/robot1/scan", (other, SCAN)[index % 2], index / 10) for index in range(40)]
        odometry = sample("/robot1/odom", Odometry(child_frame_id="base"), -4)
        found = replay(tmp_path / "goal.mcap", laser_at(0.5, 0.0), odometry, *scans)["scans"]
        assert sum(bool(each["points"]) for each in found) >= 15


def test_of_several_fixed_frames_a_wrong_one_does_not_hide_the_others(tmp_path: Path) -> None:
    stamped = [TransformStamped(child_frame_id=child) for child in ("odd", "laser")]
    for each in stamped:
        each.header.frame_id = "base"
    stamped[0].transform.translation.x = math.nan
    found = replay(
        tmp_path / "goal.mcap",
        sample("/tf_static", TFMessage(transforms=stamped), -5),
        sample("/robot1/odom", Odometry(child_frame_id="base"), -4),
        sample("/robot1/scan", SCAN, 1),
    )
    assert found["scans"] == [{"offset_s": 1.0, "points": [[2.0, 0.0]]}]


VALUES = st.lists(st.sampled_from((math.nan, 0.0, 1.0, -2.0)), min_size=1, max_size=9)


@given(VALUES, VALUES, st.integers(1, 3000), st.integers(0, 2999))
def test_what_is_thinned_keeps_its_ends_and_extreme_values(
    voltages: list[float], shares: list[float], count: int, dip: int
) -> None:
    found = [
        {"offset_s": index, "voltage": voltages[index % len(voltages)], "percentage": shares[index % len(shares)]}
        for index in range(count)
    ]
    found[dip % count]["voltage"] = -9.0
    shown = thinned(found)
    there = [each for each in found if math.isfinite(each["voltage"]) or math.isfinite(each["percentage"])]
    assert min(len(there), MOST // 4) <= len(shown) <= MOST
    assert [each["offset_s"] for each in shown] == sorted({each["offset_s"] for each in shown})
    assert {there[0]["offset_s"], there[-1]["offset_s"]} <= {each["offset_s"] for each in shown}
    for name in ("voltage", "percentage"):
        before, after = ([each[name] for each in some if math.isfinite(each[name])] for some in (found, shown))
        assert bool(before) == bool(after)
        if before:
            assert (min(before), max(before)) == (min(after), max(after))


@given(st.lists(st.booleans(), min_size=1, max_size=9), st.integers(1, 2000))
def test_of_many_scans_those_that_show_something_are_kept(pattern: list[bool], count: int) -> None:
    found = [{"offset_s": index, "points": [[1.0, 1.0]] * pattern[index % len(pattern)]} for index in range(count)]
    shown = thinned(found)
    seen, there = (sum(bool(each["points"]) for each in some) for some in (shown, found))
    assert len(shown) <= MOST
    assert seen == there if count <= MOST else seen >= min(there, MOST)


def test_of_a_recording_of_any_length_a_part_is_held(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """From its beginning to its end, evenly."""
    monkeypatch.setattr(module, "MOST_HELD", 1000)
    held = []
    monkeypatch.setattr(module, "thinned", lambda found: held.append(len(found)) or thinned(found))
    batteries = [sample("/robot1/battery_status", BatteryState(voltage=8.0), at) for at in range(5000)]
    times = [each["offset_s"] for each in replay(tmp_path / "goal.mcap", *batteries)["battery"]]
    assert max(held) <= 1000
    assert len(times) <= MOST
    assert (times[0], times[-1] > 4900) == (0.0, True)
    assert max(later - before for before, later in pairwise(times)) < 100


SOUND = [
    laser_at(0.5, 0.0),
    sample("/robot1/odom", Odometry(child_frame_id="base"), -4),
    *(sample("/robot1/scan", SCAN, at) for at in range(5)),
    *(sample("/robot1/cmd_vel", Twist(), at) for at in range(5)),
    *(sample("/robot1/battery_status", BatteryState(voltage=8.0), at) for at in range(5)),
    Sample("/robot1/camera", CAMERA, serialize_message(CompressedImage(data=b"\xff\xd8\xff picture")), BEGAN, BEGAN),
    event_sample(b'{"type": "status", "status": "executing"}', BEGAN),
    line("robot1.docking_server", "Docking", 1),
    diagnosis(DiagnosticStatus.WARN, 2),
]


@given(odd_samples(SOUND).map(as_file) | damaged(as_file(SOUND)))
def test_whatever_a_file_has_each_reader_of_recordings_ends_without_an_error(
    tmp_path_factory: pytest.TempPathFactory, data: bytes
) -> None:
    """The replay, the picture, the copy for a limited grant, and the file that a killed gateway left."""
    folder = tmp_path_factory.mktemp("odd")
    store = RecordingStore(folder, 10**9, 30, reserve=0)
    goal_id = str(UUID(int=1))
    (folder / f"{goal_id}.failed.mcap").write_bytes(data)
    (left := folder / f"{UUID(int=2)}.part").write_bytes(data)
    recording = store.find(goal_id)
    assert recording is not None
    shown = Replay(BEGAN, "cmd_vel", "/robot1").read(recording.path, lambda _: True)
    assert shown.keys() == {"scans", "velocity", "battery", "log"}
    json_response(shown)
    asyncio.run(check(store, recording))
    store.recover()
    assert not left.exists()
    assert {each.goal_id for each in store.all()} == {goal_id, str(UUID(int=2))}
    shutil.rmtree(folder)


async def check(store: RecordingStore, recording: Recording) -> None:
    recordings = Recordings(store, None)
    with suppress(NotFound):
        await recordings.picture(recording, UNLIMITED)
    assert bytes(await recordings.narrowed(recording, UNLIMITED)).startswith(b"\x89MCAP")
