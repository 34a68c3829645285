"""Docking without a detector: by the dock's pose in the database and a localization that is off, and jumps."""

import math
from collections.abc import Callable
from dataclasses import replace
from random import Random

import pytest
from benchmarks.docking.cases import CASES, Case
from benchmarks.docking.trial import run_trial, settings_of
from hypothesis import given, settings
from hypothesis import strategies as st

from docking.behaviors.feel import OFFSETS
from docking.core.errors import DockNotValid
from docking.core.geometry import Pose
from docking.core.observation import STANDSTILL, Observation
from docking.goal.dock import Docking
from docking.goal.engine import Goal
from docking.goal.outcome import Command, End, Outcome
from docking.parameters import (
    ChargingSettings,
    ChargingSource,
    ControllerName,
    DockDatabase,
    DockDirection,
    DockEntry,
    DockSettings,
    DockType,
)
from docking.plans.located import LATE, LocatedPlan
from docking.plans.registry import make_plan, sensors_of
from docking.simulation.dock import DOCKED
from docking.simulation.dock import DockSettings as SimulatedDock
from docking.simulation.faults import Fault
from docking.simulation.localization import LocalizationSettings
from docking.simulation.settings import Settings
from docking.simulation.simulation import Simulation

DOCK_POSE = ControllerName.DOCK_POSE
ROWS = [case for case in CASES if case.located]
DOCKING = settings_of(DOCK_POSE, ROWS[0])
SLOWEST = DOCKING.motion.v_linear_min


class Ride:
    """A goal in the simulation, with what the localization says of the dock."""

    def __init__(self, simulation: Simulation, docking: DockSettings = DOCKING) -> None:
        self.simulation, self.docking = simulation, docking
        self.plan = make_plan(docking)
        self.goal = Goal(self.plan, Docking(docking.timeouts, recovery=docking.recovery), simulation.time)
        self.heard_at: float | None = None  # None: now
        self.error = math.nan
        self.notes: list[str] = []

    def observe(self) -> Observation:
        simulation = self.simulation
        heard_at = simulation.time if self.heard_at is None else self.heard_at
        located = None if heard_at < 0.0 else simulation.located_docked
        observation = replace(simulation.observe(), marker=None, other_markers=(), expected_dock=located)
        return replace(observation, localized_at=heard_at, localization_error=self.error)

    def run(self, each: Callable[[Command], None] = lambda step: None) -> Outcome:
        step = self.goal.step(self.observe())
        while isinstance(step, Command):
            each(step)
            self.notes += [step.note] if step.note else []
            self.simulation.run(self.docking.control_period, step.velocity)
            step = self.goal.step(self.observe())
            assert self.simulation.time < 1500.0
        self.simulation.run(1.0, STANDSTILL)
        return step

    @property
    def contacts(self) -> list[float]:
        return [touch.speed for touch in self.simulation.touches]


@pytest.mark.parametrize("case", ROWS, ids=lambda case: case.name)
@pytest.mark.parametrize("seed", range(2))
def test_the_robot_docks_and_touches_slowly(case: Case, seed: int) -> None:
    trial = run_trial(DOCK_POSE, seed, case)
    assert trial.docked
    assert max(trial.contacts) <= SLOWEST + 1e-9


@settings(max_examples=6, derandomize=True, deadline=None)
@given(st.integers(0, 10**6))
def test_no_touch_is_fast_wherever_the_localization_has_the_dock(seed: int) -> None:
    """Nothing charges, so that the robot presses beside, too; later the localization falls silent at times."""
    random = Random(seed)
    x, y, yaw = (random.uniform(-0.1, 0.1) for _ in range(3))
    jump, after = random.uniform(0.0, 0.3), random.uniform(0.0, 30.0)
    localization = LocalizationSettings(error_x=x, error_y=y, error_yaw=yaw, noise=0.005, jump=jump)
    simulation = Simulation(Settings(start=Pose(-1.2, 0.3, -0.2), localization=localization), seed)
    simulation.set_fault(Fault.DEAD_CHARGER, True)
    docking = replace(DOCKING, timeouts=replace(DOCKING.timeouts, max_retries=1))
    docking = replace(docking, recovery=replace(docking.recovery, max_corrections=3))
    ride = Ride(simulation, docking)

    def disturb(step: Command) -> None:
        silent = simulation.time > after and simulation.time % 7.0 > 5.0
        ride.heard_at = (ride.heard_at or simulation.time) if silent else None

    outcome = ride.run(disturb)
    assert outcome.end is End.ABORTED
    assert ride.contacts
    assert max(ride.contacts) <= SLOWEST + 0.005


def test_a_jump_near_the_dock_is_not_followed() -> None:
    simulation = Simulation(Settings(start=Pose(-1.2)))
    ride = Ride(simulation)
    known: list[Pose] = []

    def disturb(step: Command) -> None:
        if step.filtered_dock_pose is not None and simulation.robot.pose.distance_to(DOCKED) < LATE - 0.02:
            known.append(simulation.odometry_origin.compose(step.filtered_dock_pose))
            simulation.set_fault(Fault.LOCALIZATION_JUMPS, True)

    assert ride.run(disturb).end is End.SUCCEEDED
    assert len(known) > 50
    assert max(pose.distance_to(known[0]) for pose in known) < 0.01


def test_a_robot_stands_still_while_the_localization_has_jumped_on_the_way_onto_the_dock() -> None:
    """At the first jump it is at rest within its stopping distance, and drives on with the pose from before."""
    simulation = Simulation(Settings(start=Pose(-1.2)), 3)
    ride = Ride(simulation)
    jumped_at: list[Pose] = []

    def disturb(step: Command) -> None:
        left = simulation.robot.pose.distance_to(DOCKED)
        simulation.set_fault(Fault.LOCALIZATION_JUMPS, LATE + 0.05 < left < 0.65)
        plan = ride.plan
        if isinstance(plan, LocatedPlan) and plan.disputed and step.stage.value == "CONTROLLING":
            jumped_at.append(simulation.robot.pose)

    for seed in range(6):
        simulation = Simulation(Settings(start=Pose(-1.2)), seed)
        ride = Ride(simulation)
        assert ride.run(disturb).end is End.SUCCEEDED
    assert jumped_at, "no start had a jump on the way"


def test_without_a_charge_the_robot_presses_a_bounded_number_of_times_and_says_where() -> None:
    simulation = Simulation(Settings(start=Pose(-1.0)))
    simulation.set_fault(Fault.DEAD_CHARGER, True)
    ride = Ride(simulation, replace(DOCKING, timeouts=replace(DOCKING.timeouts, max_retries=0)))
    outcome = ride.run()
    assert outcome.error_code == "FAILED_TO_CHARGE"
    assert len(ride.contacts) == len(OFFSETS) + 1
    assert "pressed at 21 places, -75, -50, -25, 0, 25, 50, 75 mm" in ride.notes[-1]
    assert "may be off by 0.10 m" in ride.notes[-1]
    assert simulation.time < 600.0


def test_a_robot_behind_its_dock_drives_around_it() -> None:
    simulation = Simulation(Settings(start=Pose(1.2, 0.1, 3.0)))
    ride = Ride(simulation)
    assert ride.run().end is End.SUCCEEDED
    assert simulation.bumps == 0


def test_a_robot_docks_backwards() -> None:
    dock = replace(DOCKING.dock, dock_direction=DockDirection.BACKWARD, rotate_to_dock=True)
    off = LocalizationSettings(error_y=0.05)
    simulation = Simulation(Settings(start=Pose(-1.2, 0.2), dock=SimulatedDock(at_back=True), localization=off))
    ride = Ride(simulation, replace(DOCKING, dock=dock))
    assert ride.run().end is End.SUCCEEDED
    assert max(ride.contacts) <= SLOWEST + 1e-9
    assert abs(simulation.robot.pose.theta) > 3.0


def test_without_a_localization_nothing_moves() -> None:
    ride = Ride(Simulation(Settings(start=Pose(-1.0))))
    ride.heard_at = -1.0

    def stands(step: Command) -> None:
        assert step.velocity == STANDSTILL

    outcome = ride.run(stands)
    assert outcome.error_code == "FAILED_TO_DETECT_DOCK"
    assert "nothing says where the dock is" in outcome.error_msg


def test_a_localization_that_is_lost_moves_nothing() -> None:
    ride = Ride(Simulation(Settings(start=Pose(-1.0))))
    ride.error = 0.8

    def stands(step: Command) -> None:
        assert step.velocity == STANDSTILL

    outcome = ride.run(stands)
    assert outcome.error_code == "FAILED_TO_DETECT_DOCK"
    assert "its standard deviation is 0.80 m" in outcome.error_msg


def test_a_localization_that_falls_silent_stops_the_robot_before_it_is_near() -> None:
    simulation = Simulation(Settings(start=Pose(-1.5)))
    ride = Ride(simulation)

    def fall_silent(step: Command) -> None:
        if ride.heard_at is None and step.stage.value == "CONTROLLING":
            ride.heard_at = simulation.time

    outcome = ride.run(fall_silent)
    assert outcome.error_code == "LOCALIZATION_LOST"
    assert not ride.contacts


def test_a_dock_that_is_far_away_is_left_to_nav2() -> None:
    simulation = Simulation(Settings(start=Pose(-15.0)))
    outcome = Ride(simulation).run()
    assert outcome.error_code == "FAILED_TO_STAGE"
    assert "navigate_to_staging_pose" in outcome.error_msg
    assert simulation.robot.pose.distance_to(Pose(-15.0)) < 0.01


def test_the_less_is_known_the_sooner_it_drives_slowly() -> None:
    ways = []
    for error in (math.nan, 0.12):
        simulation = Simulation(Settings(start=Pose(-1.0)))
        ride = Ride(simulation)
        ride.error = error
        slow: list[float] = []

        def note(step: Command, simulation: Simulation = simulation, slow: list[float] = slow) -> None:
            if step.stage.value == "CONTROLLING" and 0.0 < step.velocity.linear_x <= SLOWEST + 1e-9:
                slow.append(simulation.robot.pose.distance_to(DOCKED))

        assert ride.run(note).end is End.SUCCEEDED
        ways.append(max(way for way in slow if way < 0.6))
    assert ways[0] == pytest.approx(0.21, abs=0.05)
    assert ways[1] == pytest.approx(0.35, abs=0.06)


# What is refused.


def test_it_needs_no_marker() -> None:
    assert sensors_of(DOCKING) == {"odometry", "localization"}
    assert "marker" in sensors_of(DockSettings(controller=DOCK_POSE))


def test_a_goal_to_a_dock_without_a_pose_is_rejected() -> None:
    blind = replace(DockSettings(controller=DOCK_POSE).dock, use_external_detection_pose=False)
    settings = DockSettings(controller=DOCK_POSE, dock=blind)
    with pytest.raises(DockNotValid, match="has no pose"):
        settings.at_dock("")
    with pytest.raises(DockNotValid, match="'lab' has no pose"):
        replace(settings, database=DockDatabase(docks=("lab",), entries={"lab": DockEntry()})).at_dock("lab")
    assert settings.at_dock('{"pose": [1.0, 2.0, 0.5]}').by_localization


@pytest.mark.parametrize("source", list(ChargingSource))
def test_the_pose_alone_cannot_tell_that_the_battery_charges(source: ChargingSource) -> None:
    kind = DockType(use_external_detection_pose=False, charging=ChargingSettings(charging_source=source))
    database = DockDatabase(dock_plugins=("wall",), types={"wall": kind})
    conflict = DockSettings(controller=DOCK_POSE, database=database).find_conflict()
    if source is ChargingSource.POSE:
        assert conflict is not None
        assert conflict.startswith("wall.charging_source is 'pose', but with wall.use_external_detection_pose false")
    else:
        assert conflict is None


def test_the_presses_come_from_the_parameters() -> None:
    few = replace(DOCKING, recovery=replace(DOCKING.recovery, max_presses=4))
    assert few.at_dock("home").recovery.max_corrections == 4
    assert DockSettings(controller=DOCK_POSE).at_dock("").recovery.max_corrections == 2
