import math
from dataclasses import replace
from random import Random
from statistics import fmean, pstdev

import pytest

from docking.core.geometry import Pose
from docking.simulation.marker import MarkerCamera, MarkerSettings

SURE = MarkerSettings(noise=0.0, angle_noise=0.0, drop_outs=0.0)


def camera(settings: MarkerSettings = SURE) -> MarkerCamera:
    return MarkerCamera(settings, Random(1))


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
    assert (camera().look(robot) is not None) is seen


def test_it_sees_the_marker_where_it_is_from_the_robot() -> None:
    robot = Pose(-1.2, 0.3, -0.4)
    marker = camera().look(robot)
    assert marker is not None
    in_world = robot.compose(marker)
    assert (in_world.x, in_world.y, in_world.theta) == (pytest.approx(0.0), pytest.approx(0.0), pytest.approx(0.0))


def test_its_noise_is_as_large_as_it_is_set() -> None:
    robot = Pose(-1.0, 0.0, 0.0)
    looking = camera(replace(SURE, noise=0.01, angle_noise=0.02))
    seen = [pose for _ in range(4000) if (pose := looking.look(robot)) is not None]
    for values, mean, spread in (
        ([pose.x for pose in seen], 1.0, 0.01),
        ([pose.y for pose in seen], 0.0, 0.01),
        ([pose.theta for pose in seen], 0.0, 0.02),
    ):
        assert fmean(values) == pytest.approx(mean, abs=0.001)
        assert pstdev(values) == pytest.approx(spread, rel=0.05)


def test_it_drops_out_as_often_as_it_is_set() -> None:
    looking = camera(replace(SURE, drop_outs=0.2))
    missing = sum(looking.look(Pose(-1.0, 0.0, 0.0)) is None for _ in range(5000))
    assert missing / 5000 == pytest.approx(0.2, abs=0.02)
