"""Quaternions against rotation matrices."""

import math

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st

from docking.core.geometry import Pose, normalize_angle
from docking.core.transform import pose_of, spatial, tilt
from docking.parameters import Dock
from robot_io.transform import Transform, turn

Matrix = npt.NDArray[np.float64]

METRES = st.floats(-10.0, 10.0)
ANGLES = st.floats(-3.1416, 3.1416)
AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


@st.composite
def transforms(draw: st.DrawFn) -> Transform:
    rotation = Transform()
    for axis in AXES.values():
        rotation = rotation.compose(Transform(rotation=turn(axis, draw(ANGLES))))
    return Transform((draw(METRES), draw(METRES), draw(METRES)), rotation.rotation)


def about(axis: str, angle: float) -> Matrix:
    """The textbook's matrix of a turn about one axis."""
    c, s = math.cos(angle), math.sin(angle)
    rows = {
        "x": [[1, 0, 0], [0, c, -s], [0, s, c]],
        "y": [[c, 0, s], [0, 1, 0], [-s, 0, c]],
        "z": [[c, -s, 0], [s, c, 0], [0, 0, 1]],
    }
    return np.array(rows[axis], dtype=float)


def matrix(transform: Transform) -> Matrix:
    """A transform as a 4 by 4 matrix; the rotation by Rodrigues' formula."""
    x, y, z, w = transform.rotation
    sin, angle = math.hypot(x, y, z), 2.0 * math.atan2(math.hypot(x, y, z), w)
    cross = np.zeros((3, 3))
    if sin > 1e-12:
        a, b, c = x / sin, y / sin, z / sin
        cross = np.array([[0.0, -c, b], [c, 0.0, -a], [-b, a, 0.0]])
    whole = np.eye(4)
    whole[:3, :3] = np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * cross @ cross
    whole[:3, 3] = transform.translation
    return whole


def assert_same(left: Matrix, right: Matrix) -> None:
    np.testing.assert_allclose(left, right, atol=1e-9)


@given(transforms(), transforms())
def test_composing_multiplies_matrices(first: Transform, second: Transform) -> None:
    assert_same(matrix(first.compose(second)), matrix(first) @ matrix(second))


@given(transforms())
def test_the_inverse_is_that_of_the_matrix(transform: Transform) -> None:
    assert_same(matrix(transform.inverse()), np.linalg.inv(matrix(transform)))


@pytest.mark.parametrize("axis", AXES)
@given(ANGLES)
def test_a_turn_about_an_axis(axis: str, angle: float) -> None:
    assert_same(matrix(Transform(rotation=turn(AXES[axis], angle)))[:3, :3], about(axis, angle))


@given(st.builds(Pose, METRES, METRES, ANGLES), METRES)
def test_a_pose_in_the_plane_comes_back(pose: Pose, height: float) -> None:
    back = pose_of(spatial(pose, height))
    assert (back.x, back.y) == pytest.approx((pose.x, pose.y))
    assert normalize_angle(back.theta - pose.theta) == pytest.approx(0.0, abs=1e-9)


@given(transforms())
def test_the_heading_is_that_of_the_x_axis_from_above(transform: Transform) -> None:
    x, y, z = matrix(transform)[:3, 0]
    if math.hypot(x, y) < 0.499:
        with pytest.raises(ValueError, match="points up" if z > 0 else "points down"):
            pose_of(transform)
    elif math.hypot(x, y) > 0.501:
        assert normalize_angle(pose_of(transform).theta - math.atan2(y, x)) == pytest.approx(0.0, abs=1e-9)


@given(transforms(), transforms())
def test_half_way_is_as_far_from_both_ends(first: Transform, second: Transform) -> None:
    for share, there in ((0.0, first), (1.0, second)):
        np.testing.assert_allclose(matrix(first.interpolate(second, share)), matrix(there), atol=1e-6)
    middle = first.interpolate(second, 0.5)
    turned = [abs(first.inverse().compose(middle).rotation[3]), abs(middle.inverse().compose(second).rotation[3])]
    assert turned[0] == pytest.approx(turned[1], abs=1e-6)
    assert turned[0] >= math.cos(math.pi / 4) - 1e-6  # a quarter turn at most: the short way round


@given(ANGLES, ANGLES, ANGLES)
def test_roll_pitch_and_yaw_are_those_of_nav2(roll: float, pitch: float, yaw: float) -> None:
    turned = tilt(roll, pitch).compose(spatial(Pose(theta=yaw)))
    assert_same(matrix(turned)[:3, :3], about("y", pitch) @ about("x", roll) @ about("z", yaw))


@given(ANGLES)
def test_the_yaw_alone_turns_nothing_but_the_docked_robot(yaw: float) -> None:
    dock = Dock(external_detection_rotation_yaw=yaw)
    assert dock.tilt == Transform()
    assert dock.docked(Pose(1.0, 2.0, 0.5)).theta == pytest.approx(normalize_angle(0.5 + yaw))


@given(st.builds(Pose, METRES, METRES, ANGLES))
def test_an_april_tag_faces_the_robot(marker: Pose) -> None:
    """Its x axis to the right of who looks at it, y up, z out of the tag."""
    dock = Dock(external_detection_rotation_roll=-math.pi / 2, external_detection_rotation_pitch=math.pi / 2)
    axes = np.eye(4)
    axes[:3, :3] = matrix(spatial(marker))[:3, :3] @ np.array([[0, 0, -1], [-1, 0, 0], [0, 1, 0]])
    axes[:3, 3] = (marker.x, marker.y, 0.0)
    assert_same(axes @ matrix(dock.tilt), matrix(spatial(marker)))
