import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from docking.core.observation import STANDSTILL, Velocity
from docking.goal.limiter import Limiter
from docking.parameters import MotionLimits

LIMITS = MotionLimits(v_linear_max=0.26, v_angular_max=1.0, a_linear_max=0.5, a_angular_max=2.0)
WISHES = st.builds(Velocity, st.floats(-1e6, 1e6), st.floats(-1e6, 1e6))


@given(st.lists(st.tuples(WISHES, st.floats(0.0, 0.5)), max_size=40))
def test_velocity_and_acceleration_stay_within_their_limits(wishes: list[tuple[Velocity, float]]) -> None:
    limiter, last = Limiter(LIMITS), STANDSTILL
    for wish, dt in wishes:
        velocity = limiter.limit(wish, dt)
        assert abs(velocity.linear_x) <= 0.26
        assert abs(velocity.angular_z) <= 1.0
        assert abs(velocity.linear_x - last.linear_x) <= 0.5 * dt + 1e-9
        assert abs(velocity.angular_z - last.angular_z) <= 2.0 * dt + 1e-9
        last = velocity


def test_a_wish_within_the_limits_is_granted_in_the_end() -> None:
    limiter, wish = Limiter(LIMITS), Velocity(-0.2, 0.7)
    velocities = [limiter.limit(wish, 0.1) for _ in range(10)]
    assert velocities[-1] == wish
    assert math.isclose(velocities[0].linear_x, -0.05)


def test_a_stop_is_not_delayed() -> None:
    limiter = Limiter(LIMITS)
    for _ in range(20):
        limiter.limit(Velocity(0.26, 1.0), 0.1)
    assert limiter.stop() == STANDSTILL
    assert limiter.limit(STANDSTILL, 0.1) == STANDSTILL


@pytest.mark.parametrize(("wish", "expected"), [(0.02, 0.05), (-0.01, -0.05), (0.0, 0.0), (0.1, 0.1)])
def test_it_drives_at_its_slowest_or_not_at_all(wish: float, expected: float) -> None:
    limiter = Limiter(LIMITS)
    velocities = [limiter.limit(Velocity(wish, 0.0), 0.05, Velocity(0.05, 0.0)) for _ in range(20)]
    assert velocities[-1].linear_x == expected


@given(st.floats(-0.2, 0.2), st.floats(0.02, 0.1))
def test_a_slow_turn_is_made_of_faster_ones_and_the_mean_is_right(wish: float, dt: float) -> None:
    limiter, turned = Limiter(LIMITS), 0.0
    for _ in range(600):
        turned += dt * limiter.limit(Velocity(0.1, wish), dt, Velocity(0.0, 0.15)).angular_z
    assert turned == pytest.approx(600 * dt * wish, abs=0.1)


def test_a_turn_that_is_fast_enough_owes_nothing() -> None:
    limiter = Limiter(MotionLimits(v_angular_min=0.3))
    for _ in range(20):
        limiter.limit(Velocity(0.0, 0.3), 0.05)
    assert [limiter.limit(STANDSTILL, 0.2) for _ in range(3)] == [STANDSTILL] * 3


def test_a_stop_forgets_the_turn_that_was_owed() -> None:
    limiter = Limiter(LIMITS)
    limiter.limit(Velocity(0.0, 0.14), 0.2, Velocity(0.0, 0.15))
    limiter.stop()
    assert [limiter.limit(STANDSTILL, 0.1, Velocity(0.0, 0.15)) for _ in range(5)] == [STANDSTILL] * 5
