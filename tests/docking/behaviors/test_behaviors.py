import math

import pytest

from docking.behaviors.rotate import Rotate
from docking.core.observation import STANDSTILL, Observation, Velocity


def test_rotate_turns_on_the_spot_as_in_the_tutorial() -> None:
    rotate = Rotate()
    assert rotate.step(Observation(0.0), 0.0) == rotate.step(Observation(1e6), 0.1) == Velocity(0.0, 0.15)


def test_rotate_turns_as_fast_as_told() -> None:
    assert Rotate(-0.5).step(Observation(0.0), 0.0) == Velocity(0.0, -0.5)


@pytest.mark.parametrize("number", [math.nan, math.inf, -math.inf])
def test_a_velocity_with_such_a_number_is_not_finite(number: float) -> None:
    assert not Velocity(number, 0.0).finite
    assert not Velocity(0.0, number).finite
    assert STANDSTILL.finite
