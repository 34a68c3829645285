"""What a recording says of its goal."""

from pathlib import Path
from uuid import UUID

import orjson
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dock_gateway.extensions.recordings.mcap_file import McapFile
from docking.replay.recorded_goal import LONGEST, read_goal
from robot_io.recording import Sample, event_sample
from tests.support.odd_recordings import as_file, odd_events, odd_messages

S = 1_000_000_000
CHATTER = "std_msgs/msg/String"
GOAL, BEFORE = str(UUID(int=1)), str(UUID(int=2))


def event(at: float, **document: object) -> Sample:
    return event_sample(orjson.dumps(document), round(at * S))


def status(at: float, name: str, goal_id: str = GOAL, **more: object) -> Sample:
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
            status(5.0, "succeeded", BEFORE),
            status(9.9, "pending"),
            status(10.0, "accepted"),
            event(
                10.5, type="parameters", goal_id=GOAL, node="/dock", values={"a": 1.5, "b": None, "qos_overrides.x": 1}
            ),
            status(11.0, "executing", stage="CONTROLLING"),
            status(12.0, "executing", stage="CONTROLLING"),
            status(14.0, "aborted", stage="CONTROLLING", error={"code": "lost_marker", "detail": "it was lost"}),
        )
    )
    assert (goal.goal_id, goal.robot, goal.request, goal.parameters) == (GOAL, "/robot1", {"speed": 1}, {"a": 1.5})
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


def test_a_recording_with_a_gap_is_replayed_up_to_there(tmp_path: Path) -> None:
    """Such as one of a goal that said too much: what the server knew afterwards is not in it."""
    heard = [Sample("/chatter", CHATTER, b"", round(at * S), round(at * S)) for at in (0, 5, 20, 45, 80, 81)]
    states = status(1.0, "accepted"), status(2.0, "executing", stage="CONTROLLING"), status(80.0, "succeeded")
    goal = read_goal(recording(tmp_path, *states, *heard))
    assert goal.heard_until == pytest.approx(44.0)
    course, cut_at = goal.course.until(goal.heard_until)
    assert (course.stages, course.end, course.ended_at, cut_at) == ([(1.0, "CONTROLLING")], "", 44.0, 44.0)
    whole, nothing = goal.course.until(100.0)
    assert (whole.end, whole.ended_at, nothing) == ("SUCCEEDED", 79.0, None)


def test_time_stamps_far_apart_have_an_end(tmp_path: Path) -> None:
    later = 47_000_000.0
    goal = read_goal(recording(tmp_path, status(10.0, "accepted"), status(10.0 + later, "succeeded")))
    assert (goal.course.ended_at, goal.heard_until) == (later, 0.0)
    regular = [Sample("/chatter", CHATTER, b"", at * S, at * S) for at in range(10, 20_000, 20)]
    goal = read_goal(recording(tmp_path, status(10.0, "accepted"), *regular))
    assert goal.heard_until == LONGEST


@given(
    st.lists(
        st.one_of(
            odd_events(status(1.0, "accepted")),
            odd_events(status(2.0, "aborted", stage="CONTROLLING", error={"code": "blocked"})),
            odd_events(event(3.0, type="parameters", goal_id=GOAL, values={"a": 1, "b": [1.5], "qos_overrides.x": 1})),
            odd_messages(status(4.0, "executing", stage="RETRY")),
            st.just(status(5.0, "accepted")),
        )
    )
)
def test_whatever_events_say_there_is_a_goal_or_a_sentence(
    tmp_path_factory: pytest.TempPathFactory, samples: list[Sample]
) -> None:
    path = tmp_path_factory.getbasetemp() / "odd.mcap"
    path.write_bytes(as_file(samples))
    try:
        goal = read_goal(path)
    except ValueError:
        return
    assert UUID(goal.goal_id).bytes == goal.uuid
    assert goal.action.startswith("/")
    assert isinstance(goal.request, dict)
    assert all(isinstance(name, str) and value is not None for name, value in goal.parameters.items())
    assert 0.0 <= goal.heard_until <= LONGEST
    assert all(0 <= each.received_ns < 2**63 for each in goal.samples)
