"""The time of a simulation: as real time where the machine keeps up, slower and measured where it does not."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from docking.simulation.timekeeper import WINDOW, Timekeeper

PERIODS = st.lists(st.floats(0.001, 2.0), min_size=1, max_size=60)


def run(keeper: Timekeeper, periods: list[float]) -> list[float]:
    now, lapses = 0.0, []
    for period in periods:
        now += period
        lapses.append(keeper.step(now))
    return lapses


@given(PERIODS)
def test_no_time_is_invented_and_what_is_missing_is_the_lag(periods: list[float]) -> None:
    keeper = Timekeeper(0.0, longest=0.07, recovers=0.25)
    lapses = run(keeper, periods)
    assert all(0.0 <= lapse <= 0.07 for lapse in lapses)
    assert keeper.lag == pytest.approx(sum(periods) - sum(lapses), abs=1e-9)
    assert keeper.lag >= -1e-9


def test_a_machine_that_keeps_up_is_exactly_on_time() -> None:
    keeper = Timekeeper(0.0, longest=0.07, recovers=0.25)
    assert sum(run(keeper, [1 / 30] * 300)) == pytest.approx(10.0)
    assert (keeper.rate, keeper.keeps_up) == (1.0, True)
    assert keeper.lag == pytest.approx(0.0, abs=1e-9)


def test_a_short_delay_is_made_up_for() -> None:
    keeper = Timekeeper(0.0, longest=0.07, recovers=0.25)
    run(keeper, [1 / 30] * 30 + [0.2] + [1 / 30] * 30)
    assert keeper.lag == pytest.approx(0.0, abs=1e-9)
    assert keeper.keeps_up


def test_a_slow_machine_slows_the_clock_and_is_measured() -> None:
    keeper = Timekeeper(0.0, longest=0.07, recovers=0.25)
    lapses = run(keeper, [0.14] * round(2 * WINDOW / 0.14))
    assert max(lapses) == 0.07
    assert keeper.rate == pytest.approx(0.5, abs=0.02)
    assert not keeper.keeps_up
    lag = keeper.lag
    assert keeper.catch_up() == lag > 1.0
    assert keeper.catch_up() == 0.0


def test_without_recovery_a_step_is_as_long_as_it_took_up_to_a_limit() -> None:
    keeper = Timekeeper(0.0, longest=0.25, recovers=0.0)
    assert run(keeper, [0.03, 0.2, 0.9, 0.03]) == pytest.approx([0.03, 0.2, 0.25, 0.03])
