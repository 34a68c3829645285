import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from docking.core.geometry import Pose
from docking.core.transform import pose_of, spatial
from robot_io.transform import Transform
from robot_io.transform_tree import MOST, TransformError, TransformTree, nearer_frame

AT = 1000.0


def ahead(x: float) -> Transform:
    return Transform((x, 0.0, 0.0))


def tree_of(**parents: str) -> TransformTree:
    """Frames with their parents, each of them 1 m ahead of its parent."""
    tree = TransformTree()
    for child, parent in parents.items():
        tree.add(parent, child, AT, ahead(1.0), fixed=True)
    return tree


def test_a_frame_is_found_up_and_down_the_tree() -> None:
    tree = TransformTree()
    tree.add("base_footprint", "base_link", 0.0, Transform((0.0, 0.0, 0.1)), fixed=True)
    tree.add("base_link", "camera", 0.0, Transform((0.2, 0.0, 0.3), spatial(Pose(theta=math.pi / 2)).rotation))
    tree.add("base_link", "laser", 0.0, ahead(-0.1), fixed=True)
    assert tree.path("camera", "laser") == ["camera", "base_link", "laser"]
    assert tree.lookup("base_footprint", "camera", 0.0).translation == pytest.approx((0.2, 0.0, 0.4))
    assert tree.lookup("camera", "laser", 0.0).translation == pytest.approx((0.0, 0.3, -0.3))
    assert tree.lookup("laser", "laser", 0.0) == Transform()


@given(st.permutations(range(6)), st.floats(-3.0, 3.0), st.floats(-3.0, 3.0))
def test_there_and_back_is_nowhere(order: list[int], x: float, theta: float) -> None:
    tree = TransformTree()
    for child in range(1, 6):
        tree.add(str(order[child // 2]), str(order[child]), AT, spatial(Pose(x * child, 1.0, theta * child)))
    there, back = tree.lookup("0", "5", AT), tree.lookup("5", "0", AT)
    nowhere = there.compose(back)
    assert nowhere.translation == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)
    assert abs(nowhere.rotation[3]) == pytest.approx(1.0)


def test_between_two_moments_it_is_between_both() -> None:
    tree = TransformTree()
    tree.add("base_link", "camera", AT, spatial(Pose(0.0, 0.0, 0.0)))
    tree.add("base_link", "camera", AT + 1.0, spatial(Pose(1.0, 0.0, math.pi / 2)))
    quarter = pose_of(tree.lookup("base_link", "camera", AT + 0.25))
    assert (quarter.x, quarter.theta) == pytest.approx((0.25, math.pi / 8))
    assert tree.lookup("base_link", "camera", 0.0).translation[0] == 1.0  # a stamp that is not set: now


def test_a_little_before_and_after_the_ends_count() -> None:
    tree = TransformTree()
    tree.add("base_link", "camera", AT, ahead(0.0))
    tree.add("base_link", "camera", AT + 1.0, ahead(1.0))
    assert tree.lookup("base_link", "camera", AT - 0.2) == ahead(0.0)
    assert tree.lookup("base_link", "camera", AT + 1.2) == ahead(1.0)
    with pytest.raises(TransformError, match=r"from 'camera' to 'base_link' is 4\.0 s older than the measurement"):
        tree.lookup("base_link", "camera", AT + 5.0)
    with pytest.raises(TransformError, match=r"is known only from 3\.0 s after the measurement on"):
        tree.lookup("base_link", "camera", AT - 3.0)


def test_what_is_fixed_holds_at_any_time() -> None:
    tree = TransformTree()
    tree.add("base_link", "camera", AT, ahead(1.0), fixed=True)
    tree.add("base_link", "camera", AT - 5.0, ahead(2.0), fixed=True)  # told again: that one counts
    assert tree.lookup("base_link", "camera", AT + 1e6) == ahead(2.0)


def test_where_time_begins_anew_the_old_one_is_forgotten() -> None:
    tree = TransformTree()
    tree.add("base_link", "camera", AT, ahead(1.0))
    tree.add("base_link", "camera", 5.0, ahead(2.0))
    assert tree.lookup("base_link", "camera", 5.0) == ahead(2.0)


def test_old_transforms_are_forgotten() -> None:
    tree = TransformTree()
    for second in range(100):
        tree.add("base_link", "camera", AT + second, ahead(second))
    assert tree.lookup("base_link", "camera", AT + 98.5) == ahead(98.5)
    with pytest.raises(TransformError, match="known only from"):
        tree.lookup("base_link", "camera", AT + 90.0)


def test_a_frame_has_the_parent_that_was_told_last() -> None:
    tree = tree_of(camera="base_link")
    tree.add("mast", "camera", AT, ahead(3.0))
    assert tree.lookup("mast", "camera", AT) == ahead(3.0)
    with pytest.raises(TransformError, match="no transform has 'base_link'"):
        tree.lookup("base_link", "camera", AT)


def test_a_missing_link_is_named() -> None:
    tree = tree_of(camera_optical_frame="camera_link", base_link="base_footprint")
    with pytest.raises(TransformError, match="no transform relates 'camera_link' to 'base_footprint'"):
        tree.lookup("base_link", "camera_optical_frame", AT)
    with pytest.raises(TransformError, match="no transform has 'lidar'"):
        tree.lookup("base_link", "lidar", AT)
    with pytest.raises(TransformError, match="no transform has 'a' or 'b'"):
        tree.lookup("b", "a", AT)


def test_a_loop_is_an_error_and_no_endless_loop() -> None:
    tree = tree_of(a="b", b="c", c="a")
    with pytest.raises(TransformError, match="the frames are a loop: 'a' in 'b' in 'c' in 'a'"):
        tree.lookup("base_link", "a", AT)
    tree = tree_of(camera="a", a="b", b="a")
    with pytest.raises(TransformError, match="the frames are a loop: 'a' in 'b' in 'a'"):
        tree.lookup("base_link", "camera", AT)


@pytest.mark.parametrize(
    ("parent", "child", "fault"),
    [
        ("", "camera", "has a transform without the names of its frames"),
        ("base_link", "", "has a transform without the names of its frames"),
        ("camera", "camera", "has a transform from 'camera' to itself"),
    ],
)
def test_what_is_no_transform_is_refused(parent: str, child: str, fault: str) -> None:
    with pytest.raises(ValueError, match=fault):
        TransformTree().add(parent, child, AT, Transform())


def test_there_is_an_end_to_new_frames() -> None:
    tree = TransformTree()
    for number in range(MOST):
        tree.add("base_link", f"frame{number}", AT, Transform())
    with pytest.raises(ValueError, match="more than 1000 frames: 'another' is left out"):
        tree.add("base_link", "another", AT, Transform())
    tree.add("base_link", "frame7", AT + 1.0, ahead(1.0))
    assert tree.lookup("base_link", "frame7", AT + 1.0) == ahead(1.0)


def test_what_never_moves_is_kept_when_the_rest_is_forgotten() -> None:
    tree = tree_of(camera="base_link")
    tree.add("odom", "base_link", AT, Transform())
    tree.forget_moving()
    assert tree.path("camera", "base_link") == ["camera", "base_link"]
    with pytest.raises(TransformError, match="no transform has 'odom'"):
        tree.path("camera", "odom")


@pytest.mark.parametrize(
    ("frame", "expected"),
    [("camera", "base_link"), ("wheel", "base_link"), ("map", "odom"), ("dock_tag", "odom")],
)
def test_a_frame_is_related_to_the_nearer_end_of_odometry(frame: str, expected: str) -> None:
    """What odometry measures is not asked of the tree, which may say something else."""
    tree = tree_of(
        odom="map", base_footprint="odom", base_link="base_footprint", camera="base_link", wheel="base_footprint"
    )
    tree.add("map", "dock_tag", AT, ahead(5.0), fixed=True)
    assert nearer_frame(tree, frame, "odom", "base_link") == expected


def test_a_frame_is_related_to_either_end() -> None:
    assert nearer_frame(tree_of(odom="map"), "map", "odom", "base_link") == "odom"
    assert nearer_frame(tree_of(camera="base_link"), "camera", "odom", "base_link") == "base_link"
    with pytest.raises(TransformError, match="no transform has 'camera' or 'base_link'"):
        nearer_frame(tree_of(odom="map"), "camera", "odom", "base_link")


def test_the_newest_transform_of_a_way_is_as_old_as_its_oldest_link() -> None:
    tree = tree_of(laser="base_link")
    assert tree.newest("base_link", "laser") is None, "fixed ones are never old"
    tree.add("map", "odom", AT + 3.0, ahead(1.0))
    tree.add("odom", "base_link", AT + 5.0, ahead(1.0))
    assert tree.newest("odom", "map") == tree.newest("map", "odom") == AT + 3.0
    assert tree.newest("odom", "laser") == AT + 5.0
    assert tree.newest("map", "laser") == AT + 3.0
    with pytest.raises(TransformError):
        tree.newest("map", "nowhere")
