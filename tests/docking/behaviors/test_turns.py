import math

import pytest

from docking.behaviors.turns import FullTurn, Rotate
from docking.core.geometry import Pose, normalize_angle
from docking.core.observation import STANDSTILL, Observation, Odometry, Velocity
from docking.goal.behavior import Done
from docking.parameters import MotionLimits


def test_rotate_turns_on_the_spot_as_in_the_tutorial() -> None:
    rotate = Rotate()
    assert rotate.step(Observation(0.0), 0.0) == rotate.step(Observation(1e6), 0.1) == Velocity(0.0, 0.15)


def test_rotate_turns_as_fast_as_told() -> None:
    assert Rotate(-0.5).step(Observation(0.0), 0.0) == Velocity(0.0, -0.5)


@pytest.mark.parametrize("start", [0.0, 3.1, -1.0])
def test_it_turns_once_to_the_left_on_the_spot(start: float) -> None:
    behavior, heading, dt = FullTurn(MotionLimits()), start, 0.05
    for _ in range(1000):
        odometry = Odometry(Pose(theta=normalize_angle(heading)), STANDSTILL, 0.0)
        step = behavior.step(Observation(0.0, odometry=odometry), dt)
        if isinstance(step, Done):
            break
        assert step.linear_x == 0.0
        assert 0.0 < step.angular_z <= 1.0
        heading += step.angular_z * dt
    assert heading - start == pytest.approx(math.tau, abs=math.radians(3.0))


def test_without_odometry_it_stands_still() -> None:
    assert FullTurn(MotionLimits()).step(Observation(0.0), 0.05) == STANDSTILL
