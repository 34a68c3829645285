import math

import pytest

from docking.core.observation import STANDSTILL, Velocity


@pytest.mark.parametrize("number", [math.nan, math.inf, -math.inf])
def test_a_velocity_with_such_a_number_is_not_finite(number: float) -> None:
    assert not Velocity(number, 0.0).finite
    assert not Velocity(0.0, number).finite
    assert STANDSTILL.finite
