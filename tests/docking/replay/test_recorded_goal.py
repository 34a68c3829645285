"""What a recording says of its goal."""

from pathlib import Path

import orjson
import pytest

from dock_gateway.recordings.mcap_file import McapFile
from docking.replay.recorded_goal import read_goal
from robot_io.recording import Sample, event_sample

S = 1_000_000_000
CHATTER = "std_msgs/msg/String"


def event(at: float, **document: object) -> Sample:
    return event_sample(orjson.dumps(document), round(at * S))


def status(at: float, name: str, goal_id: str = "g1", **more: object) -> Sample:
    about = {"action_name": "/robot1/dock", "action_type": "some_msgs/action/Dock", "goal": {"speed": 1}}
    return event(at, type="status", goal_id=goal_id, status=name, **about, **more)


def recording(folder: Path, *samples: Sample) -> Path:
    path = folder / "goal.mcap"
    with path.open("wb") as file:
        McapFile(file).write(samples)  # not finished, as after a crash
    return path


def test_the_course_of_a_goal(tmp_path: Path) -> None:
    goal = read_goal(
        recording(
            tmp_path,
            status(5.0, "succeeded", "before"),
            status(9.9, "pending"),
            status(10.0, "accepted"),
            event(
                10.5, type="parameters", goal_id="g1", node="/dock", values={"a": 1.5, "b": None, "qos_overrides.x": 1}
            ),
            status(11.0, "executing", stage="CONTROLLING"),
            status(12.0, "executing", stage="CONTROLLING"),
            status(14.0, "aborted", stage="CONTROLLING", error={"code": "lost_marker", "detail": "it was lost"}),
        )
    )
    assert (goal.goal_id, goal.robot, goal.request, goal.parameters) == ("g1", "/robot1", {"speed": 1}, {"a": 1.5})
    assert goal.course.stages == [(1.0, "CONTROLLING")]
    assert (goal.course.end, goal.course.error_code, goal.course.ended_at) == ("ABORTED", "LOST_MARKER", 4.0)


def test_messages_come_as_if_the_gateway_had_never_been_busy(tmp_path: Path) -> None:
    """The clock of the sender is an hour ahead, and the second of three messages was noted late."""
    sent = [
        Sample("/chatter", CHATTER, b"", (3600 + at) * S, round((at + late) * S))
        for at, late in ((1, 0.1), (2, 0.9), (3, 0.1))
    ]
    goal = read_goal(recording(tmp_path, status(0.0, "accepted"), *sent))
    assert [goal.seconds(each) for each in goal.samples[1:]] == pytest.approx([1.1, 2.1, 3.1])


def test_what_is_no_recording_of_a_goal(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="cannot be read: No such file"):
        read_goal(tmp_path / "missing.mcap")
    (tmp_path / "text.mcap").write_text("hello")
    with pytest.raises(ValueError, match="no message in it that can be read"):
        read_goal(tmp_path / "text.mcap")
    with pytest.raises(ValueError, match="no goal that an action server accepted"):
        read_goal(recording(tmp_path, status(1.0, "pending"), status(1.1, "rejected")))
