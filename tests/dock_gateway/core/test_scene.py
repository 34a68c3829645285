"""Poses of several frames become one picture."""

import math
import re

import orjson
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dock_gateway.core.scene import BASE, FARTHEST, ODOM, WORLD, EvenRate, Pose, Scene, SeenPose

numbers = st.floats(-10, 10)
poses = st.builds(Pose, numbers, numbers, st.floats(-3.1, 3.1))


def near(first: dict[str, float] | None, second: Pose) -> bool:
    assert first is not None
    turn = math.remainder(first["theta"] - second.theta, math.tau)
    return max(abs(first["x"] - second.x), abs(first["y"] - second.y), abs(turn)) < 2e-4


@given(poses, poses)
def test_what_is_composed_can_be_undone(first: Pose, second: Pose) -> None:
    assert near(first.inverse().compose(first.compose(second)).document(), second)


def test_a_pose_ahead_and_to_the_left() -> None:
    robot = Pose(1.0, 2.0, math.pi / 2)
    assert near(robot.compose(Pose(0.5, 0.25, 0.0)).document(), Pose(0.75, 2.5, math.pi / 2))


def test_nothing_is_shown_of_a_robot_that_nobody_sees() -> None:
    scene = Scene()
    assert scene.document(0.0) is None
    scene.place(SeenPose(Pose(1, 2, 3), ODOM, 100.0, 0.0))
    assert scene.document(0.5) is not None
    assert scene.document(1.1) is None


def test_a_real_robot_is_shown_in_odom() -> None:
    scene = Scene()
    robot = Pose(-1.0, 0.5, -0.3)
    scene.place(SeenPose(robot, ODOM, 100.0, 0.0))
    scene.say("marker", SeenPose(Pose(1.0, 0.0, 0.1), BASE, 100.0, 0.0))
    scene.say("staging", SeenPose(Pose(-0.9, 0.0, 0.0), ODOM, 100.0, 0.0))
    scene.say("docked", SeenPose(Pose(0.0, 0.0, 0.0), "camera", 100.0, 0.0))  # nobody says where that is
    scene.set_range("center", math.inf, 0.0)
    scene.set_range("left", 0.42, 0.0)
    document = scene.document(0.1)
    assert document is not None
    assert (document["frame"], document["dock"], document["docked"]) == (ODOM, None, None)
    assert near(document["robot"], robot)
    assert near(document["marker"], robot.compose(Pose(1.0, 0.0, 0.1)))
    assert document["staging"] == {"x": -0.9, "y": 0.0, "theta": 0.0}
    assert document["infrared"] == {"left": 0.42, "center": None, "right": None}


def test_a_footprint_is_in_the_scene_once_it_is_known() -> None:
    scene = Scene()
    scene.place(SeenPose(Pose(1, 2, 3), ODOM, 100.0, 0.0))
    assert (scene.document(0.0) or {})["footprint"] is None
    scene.set_footprint({"radius": 0.3, "points": None})
    assert (scene.document(0.0) or {})["footprint"] == {"radius": 0.3, "points": None}


@given(poses, poses, poses)
def test_what_odometry_believes_is_shown_where_it_is_in_truth(truth: Pose, believed: Pose, goal: Pose) -> None:
    scene = Scene()
    scene.place(SeenPose(believed, ODOM, 100.0, 0.0))
    scene.place(SeenPose(truth, WORLD, 100.0, 0.0))
    scene.set_dock(Pose(0.0, 0.0, 0.0))
    scene.say("docked", SeenPose(believed.compose(goal), ODOM, 100.0, 0.0))
    document = scene.document(0.0)
    assert document is not None
    assert (document["frame"], document["dock"]) == (WORLD, {"x": 0.0, "y": 0.0, "theta": 0.0})
    assert near(document["robot"], truth)
    assert near(document["docked"], truth.compose(goal))


def test_frames_are_related_by_poses_of_one_moment() -> None:
    scene = Scene()
    for step in range(3):
        scene.place(SeenPose(Pose(step, 0.0, 0.0), ODOM, step, 0.0))
        scene.say("staging", SeenPose(Pose(5.0, 0.0, 0.0), ODOM, step, 0.0))
        if step:  # the truth of the moment has not come yet
            document = scene.document(0.0)
            assert document is not None
            assert document["staging"]["x"] == 15.0
        scene.place(SeenPose(Pose(step + 10.0, 0.0, 0.0), WORLD, step, 0.0))


def test_frames_are_related_whichever_is_ahead() -> None:
    scene = Scene()
    for step in range(5):  # the truth is always a moment late, and the robot is set down elsewhere on the way
        scene.place(SeenPose(Pose(step, 0.0, 0.0), ODOM, step, 0.0))
        scene.place(SeenPose(Pose(step - 1.0 + (10.0 if step < 3 else 20.0), 0.0, 0.0), WORLD, step - 1.0, 0.0))
    scene.say("staging", SeenPose(Pose(5.0, 0.0, 0.0), ODOM, 4.0, 0.0))
    document = scene.document(0.0)
    assert document is not None
    assert document["staging"]["x"] == 25.0


def test_a_marker_is_where_it_was_seen_from() -> None:
    scene = Scene()
    for step in range(5):
        scene.place(SeenPose(Pose(step / 10, 0.0, 0.0), ODOM, step, 0.0))
    scene.say("marker", SeenPose(Pose(1.0, 0.0, 0.0), BASE, 2.1, 0.0))
    document = scene.document(0.0)
    assert document is not None
    assert document["marker"]["x"] == 1.2


@pytest.mark.parametrize(("name", "after"), [("marker", 0.6), ("docked", 1.6), ("staging", 1.6)])
def test_what_is_no_longer_said_is_forgotten(name: str, after: float) -> None:
    scene = Scene()
    scene.say(name, SeenPose(Pose(1.0, 0.0, 0.0), ODOM, 0.0, 0.0))
    scene.set_range("left", 1.0, 0.0)
    for now, there in ((0.4, True), (after, False)):
        scene.place(SeenPose(Pose(0.0, 0.0, 0.0), ODOM, now, now))
        document = scene.document(now)
        assert document is not None
        assert (document[name] is not None) is there
        assert (document["infrared"] is not None) is there


def test_truth_that_ends_leaves_odometry() -> None:
    scene = Scene()
    scene.place(SeenPose(Pose(7.0, 0.0, 0.0), WORLD, 0.0, 0.0))
    scene.place(SeenPose(Pose(1.0, 0.0, 0.0), ODOM, 2.0, 2.0))
    document = scene.document(2.0)
    assert document is not None
    assert (document["frame"], document["robot"]["x"]) == (ODOM, 1.0)


@given(st.floats(5.0, 500.0))
def test_the_pace_is_kept_whatever_comes(rate: float) -> None:
    pace = EvenRate(20.0)
    sent = [now for tick in range(int(10 * rate)) if pace.due(now := tick / rate)]
    assert len(sent) <= 201
    assert len(sent) >= 9.8 * min(rate, 20.0)


@given(
    x=st.floats(),
    y=st.floats(),
    turn=st.tuples(st.floats(), st.floats(), st.floats(), st.floats()),
    distance=st.floats(),
)
def test_what_cannot_be_right_is_never_shown(
    x: float, y: float, turn: tuple[float, float, float, float], distance: float
) -> None:
    scene = Scene()
    scene.set_range("left", distance, 0.0)
    try:
        pose = Pose.in_plane(x, y, turn)
    except ValueError:
        pose = Pose(1.0, 2.0, 0.0)
    scene.place(SeenPose(pose, "odom", 0.0, 0.0))
    scene.say("docked", SeenPose(pose, "base_link", 0.0, 0.0))
    document = scene.document(0.0)
    assert document is not None
    assert abs(document["robot"]["x"]) <= FARTHEST
    assert orjson.loads(orjson.dumps(document)) == document  # no NaN, no infinity
    left = document["infrared"]["left"]
    assert left is None or 0.0 <= left <= 1000.0


@pytest.mark.parametrize(
    ("x", "turn", "why"),
    [
        (math.nan, (0.0, 0.0, 0.0, 1.0), "its position is (nan, 0)"),
        (math.inf, (0.0, 0.0, 0.0, 1.0), "its position is (inf, 0)"),
        (1e30, (0.0, 0.0, 0.0, 1.0), "its position is (1e+30, 0)"),
        (0.0, (0.0, 0.0, 0.0, 0.0), "its orientation is (0, 0, 0, 0), which is no rotation"),
        (0.0, (0.0, 0.0, math.nan, 1.0), "its orientation is (0, 0, nan, 1), which is no rotation"),
        (0.0, (1e30, 0.0, 0.0, 1.0), "its orientation is"),
    ],
)
def test_a_pose_that_cannot_be_right(x: float, turn: tuple[float, float, float, float], why: str) -> None:
    with pytest.raises(ValueError, match=re.escape(why)):
        Pose.in_plane(x, 0.0, turn)


@given(theta=st.floats(-math.pi, math.pi), length=st.floats(0.2, 5.0))
def test_a_quaternion_of_another_length_is_the_same_rotation(theta: float, length: float) -> None:
    turn = (0.0, 0.0, length * math.sin(theta / 2), length * math.cos(theta / 2))
    found = Pose.in_plane(500_000.0, 9_000_000.0, turn)  # UTM
    assert found[:2] == (500_000.0, 9_000_000.0)
    assert math.remainder(found.theta - theta, math.tau) == pytest.approx(0.0, abs=1e-9)
