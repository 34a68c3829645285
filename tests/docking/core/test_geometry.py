import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from docking.core.geometry import Pose, normalize_angle, quaternion_of, yaw_of

METRES = st.floats(-100.0, 100.0)
ANGLES = st.floats(-20.0, 20.0)
POSES = st.builds(Pose, METRES, METRES, ANGLES)


def assert_same(left: Pose, right: Pose) -> None:
    assert (left.x, left.y) == pytest.approx((right.x, right.y), abs=1e-9)
    assert normalize_angle(left.theta - right.theta) == pytest.approx(0.0, abs=1e-9)


@given(POSES, POSES)
def test_what_is_seen_from_a_pose_lies_there_again_when_composed(origin: Pose, pose: Pose) -> None:
    assert_same(origin.compose(pose.relative_to(origin)), pose)


@given(POSES)
def test_a_pose_and_its_inverse_are_the_origin(pose: Pose) -> None:
    assert_same(pose.compose(pose.inverse()), Pose())


def test_compose_drives_ahead_and_turns_to_the_left() -> None:
    assert_same(Pose(1.0, 2.0, math.pi / 2).compose(Pose(3.0, 0.5, math.pi / 2)), Pose(0.5, 5.0, math.pi))


@given(ANGLES)
def test_yaw_survives_the_quaternion(angle: float) -> None:
    assert normalize_angle(yaw_of(*quaternion_of(angle)) - angle) == pytest.approx(0.0, abs=1e-9)


@given(ANGLES)
def test_a_normalized_angle_points_the_same_way(angle: float) -> None:
    normal = normalize_angle(angle)
    assert -math.pi <= normal <= math.pi
    assert (math.cos(normal), math.sin(normal)) == pytest.approx((math.cos(angle), math.sin(angle)), abs=1e-9)


def test_distance() -> None:
    assert Pose(1.0, 1.0).distance_to(Pose(4.0, 5.0)) == 5.0
