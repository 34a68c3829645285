import math

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from docking.behaviors.turns import Rotate
from docking.core.battery import BatteryReading
from docking.core.errors import (
    ErrorCode,
    FailedToCharge,
    FailedToControl,
    FailedToDetectDock,
    LostMarker,
    OdometryLost,
    Stage,
)
from docking.core.geometry import Pose
from docking.core.observation import STANDSTILL, Observation, Odometry, Velocity
from docking.goal.behavior import Behavior, Done, Failed, Step
from docking.goal.dock import Docking
from docking.goal.engine import Goal
from docking.goal.outcome import Command, End, Outcome
from docking.goal.plan import KnownPoses, SingleStage
from docking.parameters import DockTimeouts, MotionLimits

START = 1000.0


def timeouts(**values: float) -> DockTimeouts:
    """Time limits with which the first charging message counts."""
    return DockTimeouts(**{"charge_stable_for": 0.0, **values})  # type: ignore[arg-type]


LIMITS = timeouts(battery_stale_after=2.0, battery_lost_after=60.0, goal_timeout=0.0)


def make_goal(limits: DockTimeouts = LIMITS) -> Goal:
    return Goal(SingleStage(Rotate()), Docking(limits), START)


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


def test_a_reading_is_stale_only_after_its_time() -> None:
    assert make_goal().step(Observation(START, reading(1, START - 2.0))) == Outcome(End.SUCCEEDED)


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
    assert step.error_msg == "no battery message for 60 s (battery_lost_after)"


def test_a_stale_battery_is_told_from_one_that_was_never_heard() -> None:
    step = make_goal().step(Observation(START, reading(3, START - 3.0)))
    assert step.error_msg.startswith("no battery message for over 2 s")


@pytest.mark.parametrize("battery", [None, reading(3, START - 500.0)])
def test_silence_from_before_the_goal_does_not_count(battery: BatteryReading | None) -> None:
    goal = make_goal()
    assert isinstance(goal.step(Observation(START + 60.0, battery)), Command)
    assert goal.step(Observation(START + 60.1, battery)).error_code is ErrorCode.BATTERY_LOST


@pytest.mark.parametrize("status", [1, 3])
def test_a_reading_that_is_ahead_of_the_clock_counts_as_none(status: int) -> None:
    goal = make_goal()
    for now in (START, START + 60.0):
        step = goal.step(Observation(now, reading(status, START + 1000.0)))
        assert isinstance(step, Command)
        assert (step.stage, step.velocity) == (Stage.WAIT_FOR_BATTERY, STANDSTILL)
    assert goal.step(Observation(START + 60.1, None)).error_code is ErrorCode.BATTERY_LOST


def test_a_reading_may_be_ahead_by_a_tick_of_a_simulated_clock() -> None:
    goal = make_goal()
    assert goal.step(Observation(START + 90.0, reading(3, START + 90.5))) == Command(
        Stage.CONTROLLING, Velocity(0.0, 0.15)
    )
    waiting = goal.step(Observation(START + 91.0, reading(3, START + 91.6)))
    assert waiting.error_code is ErrorCode.BATTERY_STALE  # the clock comes up in a moment, so it is not lost
    assert isinstance(goal.step(Observation(START + 92.0, reading(3, START + 91.6))), Command)


def test_a_clock_that_jumps_back_aborts() -> None:
    goal = make_goal()
    goal.step(Observation(START + 10.0, reading(3, START + 10.0)))
    assert isinstance(goal.step(Observation(START + 9.5, reading(3, START + 9.5))), Command)
    step = goal.step(Observation(START + 8.9, reading(1, START + 8.9)))
    assert step == Outcome(End.ABORTED, ErrorCode.UNKNOWN, "the clock jumped back by 0.6 s")


def test_it_times_out() -> None:
    goal = make_goal(timeouts(goal_timeout=5.0))
    assert isinstance(goal.step(Observation(START + 4.9, reading(3, START + 4.9))), Command)
    step = goal.step(Observation(START + 5.0, reading(3, START + 5.0)))
    assert isinstance(step, Outcome)
    assert (step.end, step.error_code) == (End.ABORTED, ErrorCode.TIMEOUT)
    assert step.error_msg == "the goal was not reached within 5 s (goal_timeout)"


def test_a_timeout_of_less_than_a_second_counts() -> None:
    step = make_goal(timeouts(goal_timeout=0.5)).step(Observation(START + 0.5, reading(3, START + 0.5)))
    assert step.error_code is ErrorCode.TIMEOUT


def test_charging_counts_even_in_the_moment_of_the_timeout() -> None:
    goal = make_goal(timeouts(goal_timeout=5.0))
    assert goal.step(Observation(START + 5.0, reading(1, START + 5.0))) == Outcome(End.SUCCEEDED)


@pytest.mark.parametrize("velocity", [Velocity(math.nan, 0.0), Velocity(0.0, math.inf)])
def test_a_velocity_that_is_no_number_aborts(velocity: Velocity) -> None:
    class Broken:
        def step(self, observation: Observation, dt: float) -> Velocity:
            return velocity

    step = Goal(SingleStage(Broken()), Docking(LIMITS), START).step(Observation(START, reading(3, START)))
    assert isinstance(step, Outcome)
    assert (step.end, step.error_code) == (End.ABORTED, ErrorCode.FAILED_TO_CONTROL)
    assert str(velocity) in step.error_msg


def test_the_first_outcome_stays() -> None:
    goal = make_goal()
    canceled = goal.cancel()
    assert goal.step(Observation(START, reading(1, START))) is canceled
    assert goal.abort(ErrorCode.PREEMPTED, "late") is canceled
    assert canceled == Outcome(End.CANCELED)


@given(st.lists(st.tuples(st.floats(0.0, 30.0), st.one_of(st.none(), st.integers(0, 255))), min_size=1, max_size=60))
@example([(0.0, 0), (0.0, 1)])  # in the same instant of a simulated clock
def test_it_never_moves_on_a_stale_battery_and_never_after_its_end(events: list[tuple[float, int | None]]) -> None:
    goal = make_goal(timeouts(battery_stale_after=2.0, battery_lost_after=20.0, goal_timeout=100.0))
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


class Script:
    """A plan with motion limits whose controllers do what the test says for their stage.

    Attributes:
        steps: By stage, what its controller does; without an entry, it is done at once.
    """

    stages = (Stage.INITIAL_PERCEPTION, Stage.CONTROLLING)
    motion = MotionLimits()
    lost = LostMarker
    poses = KnownPoses()

    def __init__(self, **steps: Step) -> None:
        self.steps = steps
        self.stage = self.stages[0]

    def observe(self, observation: Observation) -> None: ...

    def controller(self, stage: Stage) -> Behavior:
        self.stage = stage
        return self

    def step(self, observation: Observation, dt: float) -> Step:
        return self.steps.get(self.stage.value, Done())


class Run:
    """A goal with a scripted plan, stepped by the clock with a fresh battery and odometry."""

    def __init__(self, limits: DockTimeouts = LIMITS, **steps: Step) -> None:
        self.plan = Script(**steps)
        self.goal = Goal(self.plan, Docking(limits), START)
        self.now = START

    def step(self, seconds: float = 0.0, *, odometry: bool = True, battery: bool = True) -> Command | Outcome:
        self.now += seconds
        return self.goal.step(
            Observation(
                self.now,
                reading(3, self.now) if battery else None,
                odometry=Odometry(Pose(), STANDSTILL, self.now) if odometry else None,
            )
        )


NO_CHARGE, NOT_FOUND, NO_ODOMETRY = (
    Failed(FailedToCharge("no charge")),
    Failed(FailedToDetectDock("no dock")),
    Failed(OdometryLost("no odometry")),
)
FAST = Velocity(0.26, 1.0)


def test_velocities_keep_the_limits() -> None:
    run = Run(INITIAL_PERCEPTION=FAST)
    assert run.step() == Command(Stage.INITIAL_PERCEPTION, STANDSTILL)
    step = run.step(0.125)
    assert step.velocity == pytest.approx(Velocity(0.5 * 0.125, 2.0 * 0.125))


def test_it_stands_still_without_odometry() -> None:
    run = Run(INITIAL_PERCEPTION=FAST)
    run.step()
    run.step(0.125)
    assert run.step(0.5, odometry=False).velocity == STANDSTILL
    assert run.step(0.125).velocity == pytest.approx(Velocity(0.5 * 0.125, 2.0 * 0.125)), "from a standstill"


def test_a_stage_may_take_its_time_and_no_longer() -> None:
    run = Run(timeouts(initial_perception_timeout=2.0, max_retries=0), INITIAL_PERCEPTION=STANDSTILL)
    for _ in range(8):
        assert isinstance(run.step(0.25), Command)
    step = run.step(0.25)
    assert (step.error_code, step.error_msg) == (
        ErrorCode.FAILED_TO_DETECT_DOCK,
        "the dock was not found within 2 s (initial_perception_timeout)",
    )


def test_each_stage_has_its_own_time() -> None:
    run = Run(timeouts(initial_perception_timeout=2.0, dock_approach_timeout=2.0), INITIAL_PERCEPTION=STANDSTILL)
    for _ in range(7):
        run.step(0.25)
    run.plan.steps = {"CONTROLLING": STANDSTILL}
    run.step(0.25)
    for _ in range(8):
        assert run.step(0.25) == Command(Stage.CONTROLLING, STANDSTILL)
    assert run.step(0.25).error_code is ErrorCode.FAILED_TO_CONTROL


def test_each_failure_is_a_retry_until_there_are_no_more() -> None:
    run = Run(timeouts(max_retries=2), CONTROLLING=NO_CHARGE)
    run.step()
    for retries in (1, 2):
        assert run.step(0.1) == Command(Stage.RETRY, STANDSTILL, ErrorCode.FAILED_TO_CHARGE, "no charge", retries)
        assert run.step(0.1) == Command(Stage.INITIAL_PERCEPTION, STANDSTILL, retries=retries)
        assert run.step(0.1) == Command(Stage.CONTROLLING, STANDSTILL, retries=retries)
    assert run.step(0.1) == Outcome(End.ABORTED, ErrorCode.FAILED_TO_CHARGE, "no charge", 2)


def test_retries_are_told_while_it_waits_and_when_it_is_canceled() -> None:
    run = Run(CONTROLLING=NO_CHARGE)
    run.step()
    run.step()
    step = run.step(3.0, battery=False)
    assert (step.error_code, step.retries) == (ErrorCode.BATTERY_STALE, 1)
    assert run.goal.cancel() == Outcome(End.CANCELED, retries=1)


def test_a_dock_that_is_not_found_again_was_lost() -> None:
    run = Run(CONTROLLING=NO_CHARGE)
    for _ in range(3):
        run.step()
    run.plan.steps["INITIAL_PERCEPTION"] = NOT_FOUND
    message = "no dock, although it was seen before. Noted on the way: no charge"
    assert run.step() == Outcome(End.ABORTED, ErrorCode.LOST_MARKER, message, 1)


@pytest.mark.parametrize(
    ("failed", "error", "message"),
    [
        (Failed(FailedToControl("stuck")), ErrorCode.FAILED_TO_CHARGE, "no charge; then, while backing off: stuck"),
        (NO_ODOMETRY, ErrorCode.ODOMETRY_LOST, "no odometry. Noted on the way: no charge"),
    ],
)
def test_a_failure_while_backing_off(failed: Failed, error: ErrorCode, message: str) -> None:
    run = Run(CONTROLLING=NO_CHARGE, RETRY=failed)
    run.step()
    run.step()
    assert run.step() == Outcome(End.ABORTED, error, message, 1)


def test_a_failure_while_the_battery_charges_is_as_far_as_it_gets() -> None:
    """Pressing on, the robot has reached the charger: it stands still until that has lasted."""
    plan = Script(CONTROLLING=NO_CHARGE)
    plan.stages = (Stage.INITIAL_PERCEPTION, Stage.CONTROLLING, Stage.WAIT_FOR_CHARGE)  # type: ignore[assignment]
    goal = Goal(plan, Docking(timeouts(charge_stable_for=1.0)), START)

    def step(status: int, at: float) -> Command | Outcome:
        return goal.step(Observation(START + at, reading(status, START + at), Odometry(Pose(), STANDSTILL, START + at)))

    step(3, 0.0)
    assert plan.stage is Stage.CONTROLLING
    assert step(1, 0.25) == Command(Stage.WAIT_FOR_CHARGE, STANDSTILL)
    assert plan.stage is Stage.WAIT_FOR_CHARGE
    assert step(1, 1.0) == Command(Stage.WAIT_FOR_CHARGE, STANDSTILL)
    assert step(1, 1.25) == Outcome(End.SUCCEEDED)
