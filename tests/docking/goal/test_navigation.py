"""A goal that begins with a navigation: what is decided, and every way out cancels it."""

from dataclasses import dataclass, field, replace

import pytest

from docking.behaviors.turns import Rotate
from docking.core.battery import BatteryReading
from docking.core.errors import ErrorCode, FailedToDetectDock, FailedToStage, Stage
from docking.core.geometry import Pose
from docking.core.observation import STANDSTILL, Observation, Odometry
from docking.goal.behavior import Behavior
from docking.goal.dock import Docking
from docking.goal.engine import Goal
from docking.goal.navigation import CannotNavigate, Going, Navigation, RideState
from docking.goal.outcome import Command, End, Outcome
from docking.goal.plan import KnownPoses
from docking.parameters import DockTimeouts, MotionLimits, NavigationSettings

PERIOD = 0.1
LOW, CHARGING = 3, 1
LIMITS = DockTimeouts(goal_timeout=100.0, charge_stable_for=0.5)
SETTINGS = NavigationSettings(navigate_to_staging_pose=True, max_staging_time=30.0)


@dataclass
class Ride:
    state: RideState = RideState.ASKED
    reason: str = ""
    feedback: int = 0
    canceled: bool = False

    def cancel(self) -> None:
        self.canceled = True


@dataclass
class Navigator:
    """A navigator that a test leads.

    Attributes:
        left: The distance; None where it is not known.
        talks: Whether its rides give feedback.
    """

    left: float | None = 4.0
    talks: bool = True
    rides: list[Ride] = field(default_factory=list)
    skipped: list[str] = field(default_factory=list)

    def distance(self) -> float:
        if self.left is None:
            raise CannotNavigate("nobody is there")
        return self.left

    def send(self) -> Ride:
        self.rides.append(Ride())
        return self.rides[-1]

    def skip(self, reason: str) -> None:
        self.skipped.append(reason)


class TurningPlan:
    """Turns, once it may."""

    stages = (Stage.INITIAL_PERCEPTION, Stage.CONTROLLING)
    motion = MotionLimits()
    lost = FailedToDetectDock
    poses = KnownPoses()

    def observe(self, observation: Observation) -> None:
        """Nothing to remember."""

    def controller(self, stage: Stage) -> Behavior:
        return Rotate(0.5)


class Trial:
    """A goal with a robot that moves whatever it is told."""

    def __init__(self, navigator: Navigator, limits: DockTimeouts = LIMITS) -> None:
        self.navigator = navigator
        self.goal = Goal(TurningPlan(), Docking(limits), 0.0)
        self.goal.navigate_first(Navigation(navigator, SETTINGS))
        self.now, self.speed = 0.0, 0.5
        self.steps: list[Command] = []

    def step(self, battery: int | None = LOW, *, odometry: bool = True) -> Command | Outcome:
        seen = Odometry(Pose(self.speed * self.now), STANDSTILL, self.now) if odometry else None
        reading = None if battery is None else BatteryReading(battery, self.now)
        if self.navigator.rides and self.navigator.talks:
            self.navigator.rides[-1].feedback += 1
        step = self.goal.step(Observation(self.now, reading, seen))
        self.now += PERIOD
        return step

    def run(self, seconds: float, battery: int | None = LOW, *, odometry: bool = True) -> Command | Outcome:
        step = self.step(battery, odometry=odometry)
        for _ in range(round(seconds / PERIOD)):
            if isinstance(step, Outcome):
                break
            step = self.step(battery, odometry=odometry)
        return step

    def drive(self) -> Ride:
        """Until the server has accepted."""
        assert self.step() == Command(Stage.NAV_TO_STAGING_POSE, STANDSTILL, yields=True)
        (ride,) = self.navigator.rides
        ride.state = RideState.DRIVING
        return ride


def test_the_plan_begins_when_the_staging_pose_is_reached() -> None:
    trial = Trial(Navigator())
    ride = trial.drive()
    # Longer than blocked_after and initial_perception_timeout: neither counts.
    assert trial.run(25.0) == Command(Stage.NAV_TO_STAGING_POSE, STANDSTILL, yields=True)
    ride.state = RideState.REACHED
    assert trial.step() == Command(Stage.INITIAL_PERCEPTION, STANDSTILL)
    step = trial.step()
    assert isinstance(step, Command)
    assert (step.stage, step.velocity.angular_z > 0.0, step.yields) == (Stage.INITIAL_PERCEPTION, True, False)
    assert not ride.canceled
    assert len(trial.navigator.rides) == 1


@pytest.mark.parametrize("left", [0.0, 0.5])
def test_a_robot_near_the_staging_pose_is_not_driven(left: float) -> None:
    trial = Trial(Navigator(left))
    assert trial.step() == Command(Stage.INITIAL_PERCEPTION, STANDSTILL)
    assert (trial.navigator.rides, trial.navigator.skipped) == ([], [])


def test_without_a_server_the_robot_waits_a_moment_and_approaches_from_where_it_is() -> None:
    trial = Trial(Navigator(None))
    assert trial.run(1.5) == Command(Stage.NAV_TO_STAGING_POSE, STANDSTILL)
    step = trial.run(1.0)
    assert isinstance(step, Command)
    assert step.stage is Stage.INITIAL_PERCEPTION
    assert trial.navigator.skipped == ["nobody is there"]


def test_a_server_that_is_found_a_moment_later_drives() -> None:
    trial = Trial(Navigator(None))
    trial.run(1.0)
    trial.navigator.left = 4.0
    trial.drive()


def test_a_failure_is_its_reason() -> None:
    trial = Trial(Navigator())
    ride = trial.drive()
    ride.state, ride.reason = RideState.FAILED, "navigate_to_pose aborted the goal: no path"
    assert trial.step() == Outcome(End.ABORTED, ErrorCode.FAILED_TO_STAGE, ride.reason)


@pytest.mark.parametrize(
    ("accepted", "fed", "reason"),
    [
        (False, 0, "navigate_to_pose did not answer for 5 s"),
        (True, 1, "navigate_to_pose gave no feedback for 5 s"),
        (True, 0, "navigate_to_pose did not reach the staging pose within 30 s (max_staging_time)"),
    ],
)
def test_a_server_that_is_silent_or_slow_is_canceled(accepted: bool, fed: int, reason: str) -> None:
    trial = Trial(Navigator(talks=False))
    ride = trial.drive()
    ride.state = RideState.DRIVING if accepted else RideState.ASKED
    ride.feedback = fed
    assert trial.run(40.0) == Outcome(End.ABORTED, ErrorCode.FAILED_TO_STAGE, reason)
    assert ride.canceled


def navigation(navigator: Navigator, **settings: float) -> Navigation:
    return Navigation(navigator, replace(SETTINGS, **settings))  # type: ignore[arg-type]


def test_the_way_may_take_max_staging_time() -> None:
    navigator = Navigator()
    going = navigation(navigator, max_staging_time=1.0)
    assert going.step(0.5) is Going.DRIVES
    navigator.rides[0].state = RideState.DRIVING
    assert [going.step(0.5) for _ in range(2)] == [Going.DRIVES] * 2
    with pytest.raises(FailedToStage):
        going.step(0.5)


def test_a_server_may_take_5_s_to_answer() -> None:
    going = navigation(Navigator())
    assert [going.step(1.0) for _ in range(6)] == [Going.DRIVES] * 6
    with pytest.raises(FailedToStage):
        going.step(1.0)


def test_feedback_may_stay_away_for_5_s_from_the_last_one_on() -> None:
    navigator = Navigator()
    going = navigation(navigator)
    going.step(1.0)
    (ride,) = navigator.rides
    ride.state, ride.feedback = RideState.DRIVING, 1
    assert [going.step(1.0) for _ in range(4)] == [Going.DRIVES] * 4
    ride.feedback = 2
    assert [going.step(1.0) for _ in range(6)] == [Going.DRIVES] * 6
    with pytest.raises(FailedToStage):
        going.step(1.0)


def test_after_an_interruption_the_server_is_waited_for_again() -> None:
    navigator = Navigator(None)
    going = navigation(navigator)
    assert [going.step(0.5) for _ in range(3)] == [Going.WAITS] * 3
    navigator.left = 4.0
    assert going.step(0.5) is Going.DRIVES
    going.interrupt()
    navigator.left = None
    assert [going.step(0.5) for _ in range(4)] == [Going.WAITS] * 3 + [Going.OVER]


def test_every_way_out_cancels_the_navigation() -> None:
    trial = Trial(Navigator())
    ride = trial.drive()
    assert trial.goal.cancel().end is End.CANCELED
    assert ride.canceled

    for code in (ErrorCode.STOP_LATCHED, ErrorCode.PREEMPTED, ErrorCode.SHUTTING_DOWN, ErrorCode.UNKNOWN):
        trial = Trial(Navigator())
        ride = trial.drive()
        trial.goal.abort(code, "")
        assert ride.canceled

    trial = Trial(Navigator())
    ride = trial.drive()
    outcome = trial.run(6.0, odometry=False)
    assert isinstance(outcome, Outcome)
    assert (outcome.error_code, ride.canceled) == (ErrorCode.ODOMETRY_LOST, True)

    trial = Trial(Navigator(), DockTimeouts(goal_timeout=3.0))
    ride = trial.drive()
    outcome = trial.run(4.0)
    assert isinstance(outcome, Outcome)
    assert (outcome.error_code, ride.canceled) == (ErrorCode.TIMEOUT, True)


def test_it_is_canceled_while_the_battery_is_silent_and_begins_again() -> None:
    trial = Trial(Navigator())
    ride = trial.drive()
    waiting = trial.step(None)
    assert isinstance(waiting, Command)
    assert (waiting.stage, waiting.velocity, waiting.yields) == (Stage.WAIT_FOR_BATTERY, STANDSTILL, False)
    assert ride.canceled
    assert trial.step() == Command(Stage.NAV_TO_STAGING_POSE, STANDSTILL, yields=True)
    assert [ride.canceled for ride in trial.navigator.rides] == [True, False]


def test_it_is_canceled_while_odometry_is_silent_and_begins_again() -> None:
    trial = Trial(Navigator())
    ride = trial.drive()
    trial.run(0.9, odometry=False)
    assert not ride.canceled
    waiting = trial.run(0.2, odometry=False)
    assert isinstance(waiting, Command)
    assert (waiting.stage, waiting.error_code) == (Stage.WAIT_FOR_ODOMETRY, ErrorCode.ODOMETRY_LOST)
    assert (waiting.velocity, waiting.yields) == (STANDSTILL, False)
    assert ride.canceled
    assert trial.step() == Command(Stage.NAV_TO_STAGING_POSE, STANDSTILL, yields=True)
    assert [ride.canceled for ride in trial.navigator.rides] == [True, False]


def test_a_clock_that_stands_still_stops_it() -> None:
    trial = Trial(Navigator())
    ride = trial.drive()
    trial.goal.pause()
    assert ride.canceled


def test_a_robot_whose_battery_charges_is_not_driven() -> None:
    trial = Trial(Navigator())
    trial.speed = 0.0
    assert trial.step(CHARGING) == Command(Stage.WAIT_FOR_CHARGE, STANDSTILL)
    assert trial.run(1.0, CHARGING) == Outcome(End.SUCCEEDED)
    assert trial.navigator.rides == []
