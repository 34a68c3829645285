import math
from collections import deque
from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from docking.core.geometry import Pose
from docking.core.observation import STANDSTILL, Velocity
from docking.estimation.motion_model import DEAD_ZONE_MAX, LAGS, USUAL_LAG, MotionModel

PERIOD = 0.05


def learn(
    lag: float = 0.0,
    *,
    dead_zone: Velocity = STANDSTILL,
    clamp: float = math.inf,
    seconds: float = 12.0,
    wishes: list[Velocity] | None = None,
    seed: int = 1,
) -> MotionModel:
    """Drive for a while with a base that is late, does not move slowly, or not fast."""
    random, model, pose = Random(seed), MotionModel(), Pose()
    coming = deque([STANDSTILL] * round(lag / 0.01))
    command = STANDSTILL
    for tick in range(round(seconds / 0.01)):
        if tick % 100 == 0:
            command = random.choice(wishes or [Velocity(0.2, 0.0), STANDSTILL, Velocity(0.1, 0.5), Velocity(0.0, -0.8)])
        if tick % round(PERIOD / 0.01) == 0:
            model.update(0.01 * tick, pose)
            model.commanded = command
        coming.append(model.commanded)
        done = coming.popleft()
        linear = 0.0 if abs(done.linear_x) < dead_zone.linear_x else min(clamp, max(-clamp, done.linear_x))
        angular = 0.0 if abs(done.angular_z) < dead_zone.angular_z else done.angular_z
        pose = pose.compose(Pose(linear * 0.01, 0.0, angular * 0.01))
    return model


def test_nothing_is_known_at_first() -> None:
    model = MotionModel()
    assert (model.lag, model.dead_zone, model.history.velocity) == (USUAL_LAG, STANDSTILL, STANDSTILL)
    assert model.ahead(Pose(1.0, 2.0, 3.0)) == Pose(1.0, 2.0, 3.0)


@settings(max_examples=25, derandomize=True)
@given(st.floats(0.0, 0.55), st.integers(0, 10**6))
def test_it_learns_how_late_the_base_is(lag: float, seed: int) -> None:
    lag = round(lag, 2)
    assert learn(lag, seed=seed, seconds=20.0).lag == pytest.approx(lag, abs=0.03)


def test_a_base_that_drives_slower_than_told_is_not_taken_for_a_late_one() -> None:
    assert learn(0.1, clamp=0.12).lag == pytest.approx(0.1, abs=0.05)


def test_without_motion_nothing_is_learned() -> None:
    model = learn(0.4, wishes=[STANDSTILL])
    assert (model.lag, model.dead_zone) == (USUAL_LAG, STANDSTILL)


@pytest.mark.parametrize("zone", [0.1, 0.15, 0.25])
def test_it_learns_from_which_velocity_on_the_base_moves(zone: float) -> None:
    model = learn(0.1, dead_zone=Velocity(0.0, zone), wishes=[Velocity(0.0, 0.8 * zone)])
    assert zone <= model.dead_zone.angular_z <= 1.4 * zone
    assert model.dead_zone.linear_x == 0.0


def test_a_base_that_moves_has_no_dead_zone() -> None:
    assert learn(0.3).dead_zone == STANDSTILL


def test_a_base_that_does_not_move_at_all_has_no_endless_dead_zone() -> None:
    model = learn(dead_zone=Velocity(9.0, 9.0), seconds=60.0)
    assert model.dead_zone == DEAD_ZONE_MAX


def test_a_base_that_stands_still_is_not_about_to_move() -> None:
    model = learn(0.0, dead_zone=Velocity(9.0, 9.0), wishes=[Velocity(0.04, 0.0)])
    assert model.ahead(Pose()) == Pose()


def test_what_it_keeps_is_bounded() -> None:
    model = MotionModel(2.0)
    model.commanded = Velocity(1.0, 0.0)
    for number in range(20_000):
        model.update(0.01 * number, Pose())
    assert 2.0 + LAGS[-1] <= model.history.commands(0.0, 200.0).way <= 2.0 * (2.0 + LAGS[-1]) + 0.01
