import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from docking.battery import BatteryReading
from docking.controllers.plan import Solo
from docking.controllers.rotate import Rotate
from docking.failures import ErrorCode, Stage
from docking.goal import Command, DockGoal, End, Limits, Outcome
from docking.observation import STANDSTILL, Observation, Velocity

START = 1000.0
LIMITS = Limits(battery_stale_after=2.0, battery_lost_after=60.0, goal_timeout=0.0)


def make_goal(limits: Limits = LIMITS) -> DockGoal:
    return DockGoal(Solo(Rotate()), limits, START)


def reading(status: int, at: float) -> BatteryReading:
    return BatteryReading(status, at)


@pytest.mark.parametrize("status", [0, 2, 3, 77])
def test_it_rotates_while_the_battery_is_not_charging(status: int) -> None:
    step = make_goal().step(Observation(START + 1.0, reading(status, START + 0.9)))
    assert step == Command(Stage.CONTROLLING, Velocity(0.0, 0.15))


@pytest.mark.parametrize("status", [1, 4])
def test_it_succeeds_when_the_battery_is_charging_or_full(status: int) -> None:
    goal = make_goal()
    goal.step(Observation(START, reading(3, START)))
    assert goal.step(Observation(START + 0.1, reading(status, START + 0.05))) == Outcome(End.SUCCEEDED)


def test_a_fresh_reading_from_before_the_goal_ends_it_at_once() -> None:
    assert make_goal().step(Observation(START, reading(1, START - 1.9))) == Outcome(End.SUCCEEDED)


def test_a_stale_reading_from_before_the_goal_does_not() -> None:
    step = make_goal().step(Observation(START, reading(1, START - 2.1)))
    assert isinstance(step, Command)
    assert (step.stage, step.velocity, step.error_code) == (
        Stage.WAIT_FOR_BATTERY,
        STANDSTILL,
        ErrorCode.BATTERY_STALE,
    )


def test_it_waits_for_the_first_reading() -> None:
    step = make_goal().step(Observation(START, None))
    assert isinstance(step, Command)
    assert step.velocity == STANDSTILL
    assert "received yet" in step.error_msg


def test_it_goes_on_when_the_battery_is_back() -> None:
    goal = make_goal()
    assert goal.step(Observation(START + 30.0, reading(3, START))).error_code is ErrorCode.BATTERY_STALE
    step = goal.step(Observation(START + 31.0, reading(3, START + 30.5)))
    assert step == Command(Stage.CONTROLLING, Velocity(0.0, 0.15))


def test_a_battery_that_stays_silent_is_lost() -> None:
    goal = make_goal()
    assert isinstance(goal.step(Observation(START + 70.0, reading(3, START + 10.0))), Command)
    step = goal.step(Observation(START + 70.1, reading(3, START + 10.0)))
    assert isinstance(step, Outcome)
    assert (step.end, step.error_code) == (End.ABORTED, ErrorCode.BATTERY_LOST)


@pytest.mark.parametrize("battery", [None, reading(3, START - 500.0)])
def test_silence_from_before_the_goal_does_not_count(battery: BatteryReading | None) -> None:
    goal = make_goal()
    assert isinstance(goal.step(Observation(START + 60.0, battery)), Command)
    assert goal.step(Observation(START + 60.1, battery)).error_code is ErrorCode.BATTERY_LOST


def test_it_times_out() -> None:
    goal = make_goal(Limits(goal_timeout=5.0))
    assert isinstance(goal.step(Observation(START + 4.9, reading(3, START + 4.9))), Command)
    step = goal.step(Observation(START + 5.0, reading(3, START + 5.0)))
    assert isinstance(step, Outcome)
    assert (step.end, step.error_code) == (End.ABORTED, ErrorCode.TIMEOUT)


def test_charging_counts_even_in_the_moment_of_the_timeout() -> None:
    goal = make_goal(Limits(goal_timeout=5.0))
    assert goal.step(Observation(START + 5.0, reading(1, START + 5.0))) == Outcome(End.SUCCEEDED)


@pytest.mark.parametrize("velocity", [Velocity(math.nan, 0.0), Velocity(0.0, math.inf)])
def test_a_velocity_that_is_no_number_aborts(velocity: Velocity) -> None:
    class Broken:
        def step(self, observation: Observation, dt: float) -> Velocity:
            return velocity

    step = DockGoal(Solo(Broken()), LIMITS, START).step(Observation(START, reading(3, START)))
    assert isinstance(step, Outcome)
    assert (step.end, step.error_code) == (End.ABORTED, ErrorCode.FAILED_TO_CONTROL)


def test_the_first_outcome_stays() -> None:
    goal = make_goal()
    canceled = goal.cancel()
    assert goal.step(Observation(START, reading(1, START))) is canceled
    assert goal.abort(ErrorCode.PREEMPTED, "late") is canceled
    assert canceled == Outcome(End.CANCELED)


@given(st.lists(st.tuples(st.floats(0.0, 30.0), st.one_of(st.none(), st.integers(0, 255))), min_size=1, max_size=60))
def test_it_never_moves_on_a_stale_battery_and_never_after_its_end(events: list[tuple[float, int | None]]) -> None:
    goal = make_goal(Limits(battery_stale_after=2.0, battery_lost_after=20.0, goal_timeout=100.0))
    now, battery, ended = START, None, None
    for pause, status in events:
        now += pause
        if status is not None:
            battery = reading(status, now)
        step = goal.step(Observation(now, battery))
        if ended is not None:
            assert step is ended
        elif isinstance(step, Outcome):
            ended = step
        elif step.velocity != STANDSTILL:
            assert battery is not None
            assert now - battery.received_at <= 2.0
            assert not battery.connected
