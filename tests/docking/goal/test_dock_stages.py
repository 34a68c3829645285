"""Docking from the first look to the end, in the simulation: stages, retries, and every failure."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import pytest

from docking.core.errors import ErrorCode, Stage
from docking.core.geometry import Pose, normalize_angle
from docking.core.observation import STANDSTILL, InfraredReading, Observation, Odometry, Velocity
from docking.goal.dock import Docking
from docking.goal.engine import Goal
from docking.goal.outcome import Command, End, Outcome
from docking.parameters import ControllerName, DockSettings, DockTimeouts, MotionLimits
from docking.plans.registry import make_plan
from docking.simulation.dock import DOCKED
from docking.simulation.faults import Fault
from docking.simulation.settings import Settings
from docking.simulation.simulation import Simulation

PERIOD = 0.05
STARTS = {ControllerName.DOCK_POSE: Pose(-1.5, 0.4, -0.3), ControllerName.INFRARED: Pose(-0.8, -0.2, 0.2)}
LIMITS = DockTimeouts(max_retries=1)
ORDER = [Stage.INITIAL_PERCEPTION, Stage.NAV_TO_STAGING_POSE, Stage.CONTROLLING]


@dataclass
class World:
    """A simulated robot with a goal to dock.

    Attributes:
        stages: As they came.
        blind: Changes what is known before the goal is told.
        happen: Called before each step.
    """

    controller: ControllerName
    limits: DockTimeouts = LIMITS
    start: Pose | None = None
    blind: Callable[[Observation], Observation] = lambda observation: observation
    happen: Callable[["World"], None] = lambda world: None
    stages: list[Stage] = field(default_factory=list)
    reasons: set[ErrorCode] = field(default_factory=set)
    last: Command | Outcome | None = None

    def __post_init__(self) -> None:
        self.simulation = Simulation(Settings(start=self.start or STARTS[self.controller]), seed=3)
        self.plan = make_plan(DockSettings(controller=self.controller))
        self.goal = Goal(self.plan, Docking(self.limits), 0.0)
        self.entered_at = 0.0

    @property
    def stage(self) -> Stage | None:
        return self.stages[-1] if self.stages else None

    @property
    def in_stage(self) -> float:
        """Seconds since the stage began."""
        return self.simulation.time - self.entered_at

    def run(self, longest: float = 400.0) -> Outcome:
        """Until the goal ends. Whatever waits, ends or begins anew stands still."""
        simulation = self.simulation
        while simulation.time < longest:
            self.happen(self)
            step = self.last = self.goal.step(self.blind(simulation.observe()))
            if isinstance(step, Outcome):
                simulation.run(1.0, STANDSTILL)
                assert simulation.robot.velocity == STANDSTILL
                return step
            if step.stage is not self.stage:
                self.stages.append(step.stage)
                self.entered_at = simulation.time
            if step.stage in {Stage.WAIT_FOR_CHARGE, Stage.WAIT_FOR_BATTERY, Stage.WAIT_FOR_ODOMETRY}:
                assert step.velocity == STANDSTILL
            self.reasons.add(step.error_code)
            simulation.run(PERIOD, step.velocity)
        raise AssertionError(f"still in {self.stages} at {simulation.robot.pose}")


def fault(fault: Fault, stage: Stage | None = None, after: float = 0.0) -> Callable[[World], None]:
    def happen(world: World) -> None:
        if stage is None or (world.stage is stage and world.in_stage >= after):
            world.simulation.set_fault(fault, True)

    return happen


both = pytest.mark.parametrize("controller", list(STARTS))


@both
def test_the_stages_follow_each_other_onto_the_dock(controller: ControllerName) -> None:
    world = World(controller)
    assert world.run() == Outcome(End.SUCCEEDED)
    assert world.stages in (ORDER, [*ORDER, Stage.WAIT_FOR_CHARGE])
    assert world.simulation.contact
    assert world.simulation.bumps == 0
    assert world.reasons == {ErrorCode.NONE}


@both
def test_the_poses_are_told_and_true(controller: ControllerName) -> None:
    world = World(controller)

    def happen(world: World) -> None:
        if world.stage is Stage.CONTROLLING and isinstance(world.last, Command):
            # The frame odom as the simulation knows it, to compare with the truth.
            robot, truth = world.simulation.odometry.pose, world.simulation.robot.pose
            docked = DOCKED.relative_to(truth)
            told = world.last.filtered_dock_pose
            assert told is not None
            assert told.relative_to(robot).distance_to(docked) < 0.06
            assert world.last.staging_pose is not None
            assert world.last.staging_pose.distance_to(told) == pytest.approx(0.7)
            assert (world.last.dock_pose is None) == (controller is ControllerName.INFRARED)

    world.happen = happen
    world.run()
    assert Stage.CONTROLLING in world.stages


def test_before_the_dock_is_seen_no_pose_is_told() -> None:
    step = World(ControllerName.DOCK_POSE).goal.step(Observation(0.0))
    assert isinstance(step, Command)
    assert (step.dock_pose, step.filtered_dock_pose, step.staging_pose) == (None, None, None)


@both
@pytest.mark.parametrize("turned", [1.2, -1.2, math.pi])
def test_a_dock_out_of_view_is_searched(controller: ControllerName, turned: float) -> None:
    start = STARTS[controller]
    world = World(controller, start=Pose(start.x, start.y, normalize_angle(start.theta + turned)))
    assert world.run() == Outcome(End.SUCCEEDED)


def test_it_presses_on_until_the_battery_has_charged_for_a_while() -> None:
    def ends_at(stable_for: float) -> tuple[Outcome, float]:
        world = World(ControllerName.DOCK_POSE, limits=replace(LIMITS, charge_stable_for=stable_for))
        outcome = world.run()
        return outcome, world.simulation.robot.x

    first, far = ends_at(0.0)
    stable, near = ends_at(1.0)
    assert first == stable == Outcome(End.SUCCEEDED)
    assert far < DOCKED.x - 0.012  # at the first contact
    assert near > DOCKED.x - 0.004


def test_a_contact_that_bounces_is_no_success_until_it_holds() -> None:
    charging_at: list[float] = []

    def bounce(observation: Observation) -> Observation:
        battery = observation.battery
        if battery is not None and battery.connected and (not charging_at or observation.now - charging_at[0] < 4.0):
            charging_at.append(observation.now)
            flicker = int((observation.now - charging_at[0]) / 0.5) % 2 == 1
            return replace(observation, battery=replace(battery, status=3 if flicker else 1))
        return observation

    world = World(ControllerName.DOCK_POSE)
    world.blind = bounce
    assert world.run() == Outcome(End.SUCCEEDED)
    assert world.simulation.time > charging_at[0] + 4.0


def test_a_robot_that_charges_when_the_goal_comes_stands_still_until_it_is_reached() -> None:
    world = World(ControllerName.DOCK_POSE, start=DOCKED)
    world.simulation.run(0.5)
    goal = Goal(world.plan, Docking(LIMITS), world.simulation.time)
    begun = world.simulation.time
    while isinstance(step := goal.step(world.simulation.observe()), Command):
        assert (step.stage, step.velocity) == (Stage.WAIT_FOR_CHARGE, STANDSTILL)
        world.simulation.run(PERIOD, step.velocity)
    assert step == Outcome(End.SUCCEEDED)
    assert world.simulation.time - begun == pytest.approx(1.0, abs=0.06)


@both
def test_contact_without_charge(controller: ControllerName) -> None:
    world = World(controller, happen=fault(Fault.DEAD_CHARGER))
    outcome = world.run()
    assert (outcome.end, outcome.error_code, outcome.retries) == (End.ABORTED, ErrorCode.FAILED_TO_CHARGE, 1)
    assert world.stages == [*ORDER, Stage.WAIT_FOR_CHARGE, Stage.RETRY, *ORDER, Stage.WAIT_FOR_CHARGE]
    assert world.in_stage < 1.0 + LIMITS.wait_charge_timeout + 0.2
    assert world.simulation.contact
    assert "wait_charge_timeout" in outcome.error_msg


@both
def test_a_charger_that_works_at_last_is_a_success(controller: ControllerName) -> None:
    def happen(world: World) -> None:
        dead = not (world.stage is Stage.WAIT_FOR_CHARGE and world.goal.retries == 1 and world.in_stage > 2.0)
        world.simulation.set_fault(Fault.DEAD_CHARGER, dead)

    world = World(controller, happen=happen)
    assert world.run() == Outcome(End.SUCCEEDED, retries=1)
    assert ErrorCode.FAILED_TO_CHARGE in world.reasons


@both
def test_retrying_backs_off_to_about_the_staging_pose(controller: ControllerName) -> None:
    xs: list[float] = []

    def happen(world: World) -> None:
        world.simulation.set_fault(Fault.DEAD_CHARGER, True)
        if world.stage is Stage.RETRY:
            xs.append(world.simulation.robot.x)

    World(controller, happen=happen).run()
    assert min(xs) == pytest.approx(-0.9, abs=0.05)


def test_a_dock_that_is_never_seen() -> None:
    world = World(ControllerName.DOCK_POSE, happen=fault(Fault.OCCLUDED_MARKER))
    outcome = world.run()
    assert (outcome.error_code, outcome.retries) == (ErrorCode.FAILED_TO_DETECT_DOCK, 0)
    assert world.simulation.time < LIMITS.initial_perception_timeout + 1.5


@pytest.mark.parametrize("after", [0.0, 1.0, 1.4])
def test_a_marker_that_is_lost(after: float) -> None:
    world = World(ControllerName.DOCK_POSE, happen=fault(Fault.OCCLUDED_MARKER, Stage.CONTROLLING, after))
    outcome = world.run()
    assert (outcome.end, outcome.error_code, outcome.retries) == (End.ABORTED, ErrorCode.LOST_MARKER, 1)
    assert world.stages == [*ORDER, Stage.RETRY, Stage.INITIAL_PERCEPTION]
    assert world.reasons == {ErrorCode.NONE, ErrorCode.LOST_MARKER}


def test_a_marker_that_comes_back_in_time_is_not_lost() -> None:
    def happen(world: World) -> None:
        hidden = world.stage is Stage.CONTROLLING and 0.5 < world.in_stage < 2.2
        world.simulation.set_fault(Fault.OCCLUDED_MARKER, hidden)

    assert World(ControllerName.DOCK_POSE, happen=happen).run() == Outcome(End.SUCCEEDED)


@pytest.mark.parametrize("silent", [False, True])
def test_a_beacon_that_is_lost(silent: bool) -> None:
    world = World(ControllerName.INFRARED)

    def blind(observation: Observation) -> Observation:
        if Stage.CONTROLLING not in world.stages:
            return observation
        dark = InfraredReading(math.inf, math.inf, math.inf, observation.now)
        return replace(observation, infrared=None if silent else dark)

    world.blind = blind
    outcome = world.run()
    assert (outcome.end, outcome.error_code, outcome.retries) == (End.ABORTED, ErrorCode.INFRARED_LOST, 1)
    assert world.stages == [*ORDER, Stage.RETRY, Stage.INITIAL_PERCEPTION]


def test_a_beacon_that_goes_dark_is_no_edge_of_its_light() -> None:
    world = World(ControllerName.INFRARED, limits=replace(LIMITS, max_retries=0))

    def blind(observation: Observation) -> Observation:
        if Stage.NAV_TO_STAGING_POSE not in world.stages:
            return observation
        return replace(observation, infrared=InfraredReading(math.inf, math.inf, math.inf, observation.now))

    world.blind = blind
    assert world.run().error_code is ErrorCode.INFRARED_LOST
    assert world.in_stage < 8.0
    assert not world.plan.poses.filtered_dock, "an edge was believed"


@pytest.mark.parametrize("seconds", [0.3, 0.8, 1.5])
def test_a_beacon_that_is_hidden_again_and_again_does_not_mislead(seconds: float) -> None:
    world = World(ControllerName.INFRARED)

    def blind(observation: Observation) -> Observation:
        if observation.infrared is None or observation.infrared.stamp % 6.0 > seconds:
            return observation
        return replace(observation, infrared=InfraredReading(math.inf, math.inf, math.inf, observation.infrared.stamp))

    world.blind = blind
    assert world.run().end is End.SUCCEEDED
    assert world.simulation.contact
    assert world.simulation.bumps == 0


def test_a_beacon_that_is_never_seen() -> None:
    world = World(ControllerName.INFRARED, start=Pose(-0.1, 0.8, 0.0))  # beside the light
    assert world.run().error_code is ErrorCode.FAILED_TO_DETECT_DOCK


@both
@pytest.mark.parametrize("stage", ORDER)
def test_a_wheel_that_is_stuck(controller: ControllerName, stage: Stage) -> None:
    start = STARTS[controller]
    turned = Pose(start.x, start.y, normalize_angle(start.theta + 2.5))  # so that it must turn at first
    world = World(controller, start=turned, happen=fault(Fault.STUCK_WHEEL, stage))
    outcome = world.run()
    assert (outcome.end, outcome.error_code) == (End.ABORTED, ErrorCode.BLOCKED)
    assert world.in_stage < 1.0 + LIMITS.blocked_after + 4.0
    assert "blocked_after" in outcome.error_msg


@both
def test_being_pushed_off_the_dock(controller: ControllerName) -> None:
    def happen(world: World) -> None:
        world.simulation.set_fault(Fault.DEAD_CHARGER, True)
        if world.stage is Stage.WAIT_FOR_CHARGE and world.in_stage == pytest.approx(1.0):
            world.simulation.push(Pose(-0.12))

    world = World(controller, happen=happen)
    outcome = world.run()
    assert (outcome.end, outcome.error_code, outcome.retries) == (End.ABORTED, ErrorCode.PUSHED_OFF, 1)
    assert world.in_stage < 4.0


@both
@pytest.mark.parametrize("stage", [None, *ORDER])
def test_odometry_that_stops(controller: ControllerName, stage: Stage | None) -> None:
    world = World(controller)
    lost_at: list[float] = []

    def blind(observation: Observation) -> Observation:
        if stage is None:
            return replace(observation, odometry=None)
        if stage not in world.stages:
            return observation
        lost_at.append(observation.now)
        assert observation.odometry is not None
        return replace(observation, odometry=replace(observation.odometry, stamp=lost_at[0]))

    world.blind = blind
    outcome = world.run()
    assert (outcome.end, outcome.error_code, outcome.retries) == (End.ABORTED, ErrorCode.ODOMETRY_LOST, 0)
    assert world.simulation.time - (lost_at or [0.0])[0] < LIMITS.odometry_timeout + 1.2


@both
@pytest.mark.parametrize("silence", [0.5, 4.5])
@pytest.mark.parametrize("stage", ORDER)
def test_odometry_that_stops_and_comes_back(controller: ControllerName, stage: Stage, silence: float) -> None:
    world = World(controller, limits=replace(LIMITS, max_retries=0))
    lost: list[Odometry] = []

    def blind(observation: Observation) -> Observation:
        assert observation.odometry is not None
        if stage in world.stages:
            lost.append(observation.odometry)
        silent = bool(lost) and observation.now < lost[0].stamp + silence
        return replace(observation, odometry=lost[0]) if silent else observation

    world.blind = blind
    assert world.run() == Outcome(End.SUCCEEDED)
    assert (Stage.WAIT_FOR_ODOMETRY in world.stages) is (silence > 1.0)
    assert (ErrorCode.ODOMETRY_LOST in world.reasons) is (silence > 1.0)
    assert world.simulation.bumps == 0


@both
def test_a_silent_battery_stops_the_robot_and_the_clocks_of_the_stages(controller: ControllerName) -> None:
    def happen(world: World) -> None:
        silent = Stage.CONTROLLING in world.stages and world.simulation.time < world.pause_until
        world.simulation.set_fault(Fault.SILENT_BATTERY, silent)

    world = World(controller, limits=replace(LIMITS, dock_approach_timeout=20.0, battery_lost_after=100.0))
    world.pause_until = 90.0  # type: ignore[attr-defined]
    world.happen = happen
    assert world.run() == Outcome(End.SUCCEEDED)
    assert world.simulation.time > 90.0
    assert Stage.WAIT_FOR_BATTERY in world.stages


def test_receivers_are_not_silent_for_the_time_that_the_robot_waits() -> None:
    def happen(world: World) -> None:
        waits, waited = world.stage is Stage.WAIT_FOR_BATTERY, Stage.WAIT_FOR_BATTERY in world.stages
        silent = world.in_stage < 3.0 if waits else world.stage is Stage.NAV_TO_STAGING_POSE and not waited
        world.simulation.set_fault(Fault.SILENT_BATTERY, silent)

    def blind(observation: Observation) -> Observation:
        odometry = observation.odometry  # the newest reading always waits for it
        return replace(observation, odometry=odometry and replace(odometry, stamp=odometry.stamp - 0.06))

    world = World(ControllerName.INFRARED, limits=replace(LIMITS, max_retries=0), blind=blind, happen=happen)
    assert world.run() == Outcome(End.SUCCEEDED)
    assert Stage.WAIT_FOR_BATTERY in world.stages


@pytest.mark.parametrize(
    ("limits", "stage", "error"),
    [
        (
            DockTimeouts(max_retries=0, initial_perception_timeout=0.2),
            Stage.INITIAL_PERCEPTION,
            "FAILED_TO_DETECT_DOCK",
        ),
        (DockTimeouts(max_retries=0, staging_timeout=1.0), Stage.NAV_TO_STAGING_POSE, "FAILED_TO_STAGE"),
        (DockTimeouts(max_retries=0, dock_approach_timeout=1.0), Stage.CONTROLLING, "FAILED_TO_CONTROL"),
        (DockTimeouts(goal_timeout=3.0), Stage.NAV_TO_STAGING_POSE, "TIMEOUT"),
    ],
)
@both
def test_every_stage_has_a_deadline(controller: ControllerName, limits: DockTimeouts, stage: Stage, error: str) -> None:
    world = World(controller, limits=limits)
    outcome = world.run()
    assert (outcome.end, outcome.error_code) == (End.ABORTED, ErrorCode(error))
    if error != "TIMEOUT":
        assert world.stage is stage
        assert world.in_stage < 2.2


def test_a_robot_that_cannot_back_off_ends_with_the_reason_why_it_wanted_to() -> None:
    def happen(world: World) -> None:
        world.simulation.set_fault(Fault.DEAD_CHARGER, True)
        world.simulation.set_fault(Fault.STUCK_WHEEL, world.stage is Stage.RETRY)

    outcome = World(ControllerName.DOCK_POSE, happen=happen).run()
    assert outcome.error_code is ErrorCode.FAILED_TO_CHARGE
    assert "backing off" in outcome.error_msg


def test_a_controller_that_gives_no_number_fails_after_the_retries() -> None:
    class Broken:
        def step(self, observation: Observation, dt: float) -> Velocity:
            return Velocity(math.nan, 0.0)

    class BrokenPlan:
        stages = (Stage.CONTROLLING,)
        motion = MotionLimits()

        def __getattr__(self, name: str) -> object:
            return getattr(World(ControllerName.DOCK_POSE).plan, name)

        def controller(self, stage: Stage) -> Broken:
            return Broken()

    simulation = Simulation(seed=1)
    goal = Goal(BrokenPlan(), Docking(DockTimeouts(max_retries=0)), 0.0)
    assert goal.step(simulation.observe()).error_code is ErrorCode.FAILED_TO_CONTROL
