import math
from dataclasses import replace
from itertools import pairwise
from random import Random
from statistics import fmean, pstdev

import pytest

from docking.core.geometry import Pose
from docking.simulation.faults import Fault
from docking.simulation.marker import CAMERA_X, GHOST, OUTLIER_ANGLE, OUTLIER_DISTANCE, MarkerCamera, MarkerSettings
from docking.simulation.obstacle import Obstacle
from docking.simulation.settings import Settings
from docking.simulation.simulation import Simulation

SURE = MarkerSettings(noise=0.0, angle_noise=0.0, drop_outs=0.0)


def camera(settings: MarkerSettings = SURE) -> MarkerCamera:
    return MarkerCamera(settings, Random(1), Random(2))


@pytest.mark.parametrize(
    ("robot", "seen"),
    [
        (Pose(-1.0, 0.0, 0.0), True),
        (Pose(-4.14, 0.0, 0.0), True),
        (Pose(-4.16, 0.0, 0.0), False),
        (Pose(-1.15 - 0.0, 0.0, math.radians(29.0)), True),
        (Pose(-1.15 - 0.0, 0.0, math.radians(32.0)), False),
        (Pose(-1.0, 0.0, math.pi), False),
        (Pose(-0.2, 0.0, 0.0), True),
        (Pose(0.5, 0.0, math.pi), False),
        (Pose(0.0, -1.0, math.pi / 2.0), False),
        (Pose(-0.3, -1.0, math.radians(70.0)), True),
        (Pose(-0.2, -1.2, math.radians(75.0)), False),
    ],
)
def test_it_sees_within_range_and_view_and_only_the_marker_front(robot: Pose, seen: bool) -> None:
    assert camera().can_see(robot) is seen
    assert (camera().detect(robot) is not None) is seen


def test_it_sees_the_marker_where_it_is_from_the_robot() -> None:
    robot = Pose(-1.2, 0.3, -0.4)
    marker = camera().detect(robot)
    assert marker is not None
    in_world = robot.compose(marker)
    assert (in_world.x, in_world.y, in_world.theta) == (pytest.approx(0.0), pytest.approx(0.0), pytest.approx(0.0))


def test_its_noise_is_as_large_as_it_is_set() -> None:
    robot = Pose(-1.0, 0.0, 0.0)
    looking = camera(replace(SURE, noise=0.01, angle_noise=0.02))
    seen = [pose for _ in range(4000) if (pose := looking.detect(robot)) is not None]
    for values, mean, spread in (
        ([pose.x for pose in seen], 1.0, 0.01),
        ([pose.y for pose in seen], 0.0, 0.01),
        ([pose.theta for pose in seen], 0.0, 0.02),
    ):
        assert fmean(values) == pytest.approx(mean, abs=0.001)
        assert pstdev(values) == pytest.approx(spread, rel=0.05)


def test_it_drops_out_as_often_as_it_is_set() -> None:
    looking = camera(replace(SURE, drop_outs=0.2))
    missing = sum(looking.detect(Pose(-1.0, 0.0, 0.0)) is None for _ in range(5000))
    assert missing / 5000 == pytest.approx(0.2, abs=0.02)


def test_its_noise_grows_with_distance_and_angle() -> None:
    looking = camera(replace(SURE, noise=0.01, noise_per_metre=0.01, noise_per_radian=0.1))
    ahead = [looking.detect(Pose(-2.15, 0.0, 0.0)) for _ in range(2000)]
    assert pstdev(pose.y for pose in ahead if pose) == pytest.approx(0.03, rel=0.1)
    assert pstdev(pose.theta for pose in ahead if pose) == pytest.approx(0.0, abs=1e-6)
    aside = [looking.detect(Pose(-1.0, -1.0, math.pi / 4.0)) for _ in range(2000)]
    assert pstdev(pose.theta for pose in aside if pose) == pytest.approx(0.1 * math.pi / 4.0, rel=0.1)


def test_its_noise_can_grow_with_the_square_of_the_distance() -> None:
    looking = camera(replace(SURE, noise=0.01, noise_per_square_metre=0.01))
    for distance, noise in ((1.0, 0.02), (2.0, 0.05)):
        seen = [looking.detect(Pose(-CAMERA_X - distance, 0.0, 0.0)) for _ in range(2000)]
        assert pstdev(pose.y for pose in seen if pose) == pytest.approx(noise, rel=0.1)


def test_nearer_than_its_minimum_range_it_sees_nothing() -> None:
    looking = camera(replace(SURE, range_min=0.3))
    assert looking.detect(Pose(-CAMERA_X - 0.31)) is not None
    assert looking.detect(Pose(-CAMERA_X - 0.29)) is None


def test_a_camera_that_is_mounted_to_the_left_sees_everything_farther_to_the_right() -> None:
    seen = camera(replace(SURE, camera_error_y=0.03)).detect(Pose(-1.0, 0.0, 0.3))
    true = camera(SURE).detect(Pose(-1.0, 0.0, 0.3))
    assert seen is not None
    assert true is not None
    assert (seen.x, seen.y, seen.theta) == (true.x, pytest.approx(true.y - 0.03), true.theta)


@pytest.mark.parametrize(("degrees", "mirrored"), [(10.0, True), (-20.0, True), (35.0, False)])
def test_a_flat_marker_is_taken_for_its_mirror_image_where_it_is_seen_nearly_from_the_front(
    degrees: float, mirrored: bool
) -> None:
    side, looking = math.radians(degrees), camera(replace(SURE, mirrored=0.5))
    robot = Pose(-math.cos(side), math.sin(side), -side).compose(Pose(-CAMERA_X))
    seen = [looking.detect(robot, 0.1 * number) for number in range(500)]
    turns = {round(math.degrees(pose.theta)) for pose in seen if pose}
    assert turns == ({degrees, -degrees} if mirrored else {degrees})
    assert len({pose.x for pose in seen if pose}) == 1
    if mirrored:  # it stays the same for half a second
        changes = sum(one != other for one, other in pairwise(seen))
        assert 30 < changes < 70


def test_the_edge_of_the_image_can_cut_a_marker_off() -> None:
    looking = camera(replace(SURE, cut_off_bias=1.0, field_of_view=math.radians(40.0)))
    whole = looking.detect(Pose(-1.0))
    assert whole is not None
    assert whole.y == pytest.approx(0.0)
    off = looking.detect(Pose(-CAMERA_X - 0.3, 0.09))  # the edge is 0.109 m from the middle there
    assert off is not None
    assert off.y == pytest.approx(-0.09 + 0.5 * (0.09 + 0.04 - 0.3 * math.tan(math.radians(20.0))))


def test_outliers_are_as_many_as_they_are_set_and_anywhere_around() -> None:
    looking, robot = camera(replace(SURE, outliers=0.3)), Pose(-1.0, 0.0, 0.0)
    seen = [pose for _ in range(3000) if (pose := looking.detect(robot)) is not None]
    wrong = [pose for pose in seen if pose != Pose(1.0, 0.0, 0.0)]
    assert len(wrong) / len(seen) == pytest.approx(0.3, abs=0.03)
    assert max(abs(pose.y) for pose in wrong) == pytest.approx(OUTLIER_DISTANCE, rel=0.05)
    assert max(abs(pose.theta) for pose in wrong) == pytest.approx(OUTLIER_ANGLE, rel=0.05)


def test_a_reflection_is_always_at_the_same_place() -> None:
    looking, robots = camera(replace(SURE, ghosts=1.0)), [Pose(-1.0, 0.0, 0.0), Pose(-1.5, 0.2, 0.1)]
    for robot in robots:
        seen = looking.detect(robot)
        assert seen is not None
        assert robot.compose(seen).distance_to(GHOST) < 1e-9


def test_it_is_hidden_again_and_again() -> None:
    looking = camera(replace(SURE, hidden_every=10.0, hidden_for=0.5))
    seen = [looking.detect(Pose(-1.0), number / 10.0) is not None for number in range(200)]
    assert [number for number, found in enumerate(seen) if not found] == [0, 1, 2, 3, 4, 100, 101, 102, 103, 104]


def test_a_camera_that_is_mounted_wrong_sees_the_marker_elsewhere() -> None:
    seen = camera(replace(SURE, mount_error=Pose(0.0, 0.01, 0.05))).detect(Pose(-1.0))
    assert seen is not None
    assert seen.theta == pytest.approx(-0.05)
    assert seen.y == pytest.approx(-0.06, abs=1e-3)


def test_a_camera_that_is_farther_ahead_sees_the_marker_nearer() -> None:
    seen = camera(replace(SURE, camera_error_x=0.05)).detect(Pose(-1.0))
    assert seen is not None
    assert seen.x == pytest.approx(0.95)


@pytest.mark.parametrize(("y", "seen"), [(0.0, False), (0.09, False), (0.11, True)])
def test_what_stands_in_between_hides_the_marker(y: float, seen: bool) -> None:
    assert (camera().detect(Pose(-1.2), 0.0, [Obstacle(-0.5, y, 0.1)]) is not None) is seen
    assert camera().detect(Pose(-1.2), 0.0, [Obstacle(-2.0, y, 0.1)]) is not None, "behind the robot"


def test_a_marker_can_be_turned_on_its_dock() -> None:
    seen = camera(replace(SURE, angle_bias=0.1)).detect(Pose(-1.0, 0.2, 0.0))
    assert seen is not None
    assert (seen.x, seen.y, seen.theta) == (pytest.approx(1.0), pytest.approx(-0.2), pytest.approx(0.1))


def test_the_clock_of_its_stamps_can_be_ahead() -> None:
    """The last detection is at most one picture old."""
    simulation = Simulation(Settings(start=Pose(-1.0), marker=replace(SURE, stamp_offset=0.3)))
    simulation.run(1.0)
    assert simulation.detection is not None
    assert simulation.detection[0] == pytest.approx(1.3, abs=0.08)
    assert not simulation.sightings, "odometry knows no pose so far ahead"
    simulation.set_fault(Fault.FUTURE_DETECTIONS, True)
    simulation.run(1.0)
    assert simulation.detection[0] == pytest.approx(2.8, abs=0.08)
