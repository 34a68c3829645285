import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from docking.behaviors.moves import steer
from docking.core.geometry import Pose, normalize_angle
from docking.parameters import Gains

ANGLES = st.floats(-math.pi, math.pi)
POSES = st.builds(Pose, st.floats(-3.0, 3.0), st.floats(-3.0, 3.0), ANGLES)


def test_it_drives_straight_to_a_target_straight_ahead() -> None:
    steering = steer(Pose(), Pose(1.0, 0.0, 0.0), Gains())
    assert steering.curvature == pytest.approx(0.0)
    assert steering.slowness == pytest.approx(1.0)


def test_it_turns_to_the_side_of_the_target() -> None:
    assert steer(Pose(), Pose(1.0, 0.5, 0.4), Gains()).curvature > 0.0
    assert steer(Pose(), Pose(1.0, -0.5, -0.4), Gains()).curvature < 0.0


def test_it_is_the_papers_equation() -> None:
    # r = 2, theta = pi/4, delta = pi/6, with k1 = 1 and k2 = 3
    steering = steer(Pose(0.0, 0.0, math.pi / 6), Pose(2.0, 0.0, math.pi / 4), Gains(k_phi=1.0, k_delta=3.0))
    theta, delta = math.pi / 4, math.pi / 6
    law = 3.0 * (delta + math.atan(theta)) + (1.0 + 1.0 / (1.0 + theta**2)) * math.sin(delta)
    assert steering.curvature == pytest.approx(-law / 2.0)
    assert steering.slowness == pytest.approx(1.0 + 0.4 * (law / 2.0) ** 2)


@given(POSES, POSES)
def test_it_is_a_number_everywhere_and_never_speeds_up(robot: Pose, target: Pose) -> None:
    steering = steer(robot, target, Gains())
    assert math.isfinite(steering.curvature)
    assert steering.slowness >= 1.0


@given(POSES, POSES, POSES)
def test_it_does_not_matter_where_the_origin_is(robot: Pose, target: Pose, origin: Pose) -> None:
    here, there = steer(robot, target, Gains()), steer(origin.compose(robot), origin.compose(target), Gains())
    if robot.distance_to(target) > 0.01 and abs(abs(robot.theta - target.theta) - math.pi) > 0.01:
        line = math.atan2(target.y - robot.y, target.x - robot.x)
        if all(abs(abs(normalize_angle(pose.theta - line)) - math.pi) > 0.01 for pose in (robot, target)):
            assert there.curvature == pytest.approx(here.curvature, rel=1e-6, abs=1e-6)


@given(st.floats(0.3, 2.5), st.floats(-math.pi / 3, math.pi / 3), st.floats(-math.pi / 3, math.pi / 3))
def test_an_ideal_robot_converges_from_the_whole_region(distance: float, bearing: float, heading: float) -> None:
    """Up to 2.5 m away and 60 degrees off, it arrives within 2 cm and 5 degrees."""
    robot = Pose(-distance * math.cos(bearing), -distance * math.sin(bearing), normalize_angle(bearing + heading))
    for _ in range(4000):
        steering = steer(robot, Pose(), Gains())
        way = 0.005 / steering.slowness
        robot = robot.compose(Pose(way, 0.0, steering.curvature * way))
        if math.hypot(robot.x, robot.y) < 0.02:
            assert abs(robot.theta) < math.radians(5.0)
            return
    pytest.fail(f"still at {robot}")
