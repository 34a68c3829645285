"""What the robot does on the contacts before an attempt is given up, and after the last attempt."""

import math
import re
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from docking.core.errors import ErrorCode, Stage
from docking.core.geometry import Pose, normalize_angle
from docking.core.observation import STANDSTILL
from docking.goal.dock_memory import DockMemory
from docking.goal.outcome import End, Outcome
from docking.nodes.dock_server import DockAction
from docking.parameters import ControllerName, DockDirection, DockSettings, RecoverySettings
from docking.simulation.dock import DOCKED
from docking.simulation.dock import DockSettings as SimulatedDock
from docking.simulation.faults import Fault
from docking.simulation.marker import MarkerSettings
from docking.simulation.settings import Settings
from docking.simulation.simulation import Simulation

STAGING = Pose(-0.9, 0.0, 0.0)
NEAR = Pose(-1.0, 0.1, -0.1)
STARTS = {ControllerName.DOCK_POSE: NEAR, ControllerName.INFRARED: Pose(-0.8, -0.2, 0.2)}
both = pytest.mark.parametrize("controller", list(STARTS))


def parameters(controller: ControllerName = ControllerName.DOCK_POSE, **recovery: float) -> DockSettings:
    """Those of a robot that tries once."""
    defaults = DockSettings(controller=controller)
    return replace(
        defaults,
        timeouts=replace(defaults.timeouts, max_retries=0),
        recovery=replace(RecoverySettings(), **recovery),  # type: ignore[arg-type]
    )


@dataclass
class Run:
    """One goal in the simulation; no command comes after its outcome, and none that moves while it waits.

    Attributes:
        way: That the wheels have driven in each stage, in m.
        stages: As they came.
        happen: Called before each step.
    """

    parameters: DockSettings
    faults: tuple[Fault, ...] = ()
    world: Settings = field(default_factory=lambda: Settings(start=NEAR))
    seed: int = 3
    happen: Callable[["Run"], None] = lambda run: None
    stages: list[Stage] = field(default_factory=list)
    way: dict[Stage, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.simulation = Simulation(self.world, self.seed)
        self.simulation.scanning = self.parameters.collision.use_collision_detection
        for fault in self.faults:
            self.simulation.set_fault(fault, True)
        self.goal = DockAction().make_goal(self.parameters, DockMemory(), 0.0)

    @property
    def stage(self) -> Stage | None:
        return self.stages[-1] if self.stages else None

    def end(self) -> Outcome:
        """Run until the goal ends, and a little longer."""
        simulation = self.simulation
        while simulation.time < 300.0:
            self.happen(self)
            step = self.goal.step(simulation.observe())
            if isinstance(step, Outcome):
                simulation.run(1.0, STANDSTILL)
                assert self.goal.step(simulation.observe()) is step
                assert simulation.robot.velocity == STANDSTILL
                return step
            if step.stage is not self.stage:
                self.stages.append(step.stage)
            before = simulation.robot.pose
            simulation.run(self.parameters.control_period, step.velocity)
            driven = before.distance_to(simulation.robot.pose)
            self.way[step.stage] = self.way.get(step.stage, 0.0) + driven
        raise AssertionError(f"still in {self.stages}")


@both
def test_dirty_contacts_are_pressed_again_instead_of_a_retry(controller: ControllerName) -> None:
    run = Run(parameters(controller), (Fault.DIRTY_CONTACTS,), Settings(start=STARTS[controller]))
    assert run.end() == Outcome(End.SUCCEEDED)
    assert run.stages.count(Stage.CORRECTING) == 1
    assert run.simulation.presses == 2


def test_without_corrections_dirty_contacts_need_a_retry() -> None:
    tries = parameters(max_corrections=0)
    run = Run(replace(tries, timeouts=replace(tries.timeouts, max_retries=1)), (Fault.DIRTY_CONTACTS,))
    assert run.end() == Outcome(End.SUCCEEDED, retries=1)
    assert Stage.CORRECTING not in run.stages


@both
def test_after_the_last_attempt_it_stands_at_its_staging_pose(controller: ControllerName) -> None:
    run = Run(parameters(controller), (Fault.DEAD_CHARGER,), Settings(start=STARTS[controller]))
    outcome = run.end()
    assert (outcome.end, outcome.error_code) == (End.ABORTED, ErrorCode.FAILED_TO_CHARGE)
    assert run.stages[-1] is Stage.RETURN_TO_STAGING
    off = run.simulation.robot.pose.relative_to(STAGING)
    assert math.hypot(off.x, off.y) < 0.08
    assert abs(off.theta) < 0.1


def test_it_stays_on_the_dock_where_that_is_wanted() -> None:
    run = Run(parameters(return_to_staging=False), (Fault.DEAD_CHARGER,))
    assert run.end().error_code is ErrorCode.FAILED_TO_CHARGE
    assert Stage.RETURN_TO_STAGING not in run.stages
    assert run.simulation.contact


def test_a_robot_that_never_came_near_the_dock_stays_where_it_is() -> None:
    defaults = parameters()
    run = Run(
        replace(defaults, timeouts=replace(defaults.timeouts, initial_perception_timeout=0.5)),
        (Fault.OCCLUDED_MARKER,),
    )
    assert run.end().error_code is ErrorCode.FAILED_TO_DETECT_DOCK
    assert run.stages == [Stage.INITIAL_PERCEPTION]


@pytest.mark.parametrize(
    ("fault", "rotates"),
    [(Fault.DIRTY_CONTACTS, False), (Fault.DEAD_CHARGER, False), (Fault.DEAD_CHARGER, True)],
)
def test_a_robot_that_docks_backwards_does_the_same_the_other_way_round(fault: Fault, rotates: bool) -> None:
    tries = parameters()
    backward = replace(tries.dock, dock_direction=DockDirection.BACKWARD, rotate_to_dock=rotates)
    world = Settings(
        start=NEAR if rotates else Pose(NEAR.x, NEAR.y, NEAR.theta + math.pi),
        marker=MarkerSettings(camera_yaw=0.0 if rotates else math.pi),
        dock=SimulatedDock(at_back=True),
    )
    run = Run(replace(tries, dock=backward), (fault,), world)
    outcome = run.end()
    assert Stage.CORRECTING in run.stages
    if fault is Fault.DIRTY_CONTACTS:
        assert outcome == Outcome(End.SUCCEEDED)
        return
    assert outcome.error_code is ErrorCode.FAILED_TO_CHARGE
    off = run.simulation.robot.pose.relative_to(STAGING)
    assert math.hypot(off.x, off.y) < 0.1
    assert abs(normalize_angle(off.theta - (0.0 if rotates else math.pi))) < 0.1


def test_an_obstacle_behind_ends_the_way_back_and_the_first_reason_stays() -> None:
    defaults = parameters(max_corrections=0)
    watched = replace(defaults.collision, use_collision_detection=True, obstacle_timeout=2.0)

    def happen(run: Run) -> None:
        run.simulation.set_fault(Fault.OBSTACLE, Stage.RETURN_TO_STAGING in run.stages)

    run = Run(replace(defaults, collision=watched), (Fault.DEAD_CHARGER,), happen=happen)
    outcome = run.end()
    assert outcome.error_code is ErrorCode.FAILED_TO_CHARGE
    assert "then, on the way back to the staging pose: the robot has waited" in outcome.error_msg
    assert Stage.WAIT_FOR_CLEARANCE in run.stages
    assert run.simulation.bumps == 0


@pytest.mark.parametrize("silent", [False, True])
def test_what_ends_the_way_back_does_not_hide_the_first_reason(silent: bool) -> None:
    defaults = parameters(max_corrections=0)

    def run(goal_timeout: float) -> tuple[Outcome, float]:
        """The outcome, and when the way back began."""
        began: list[float] = []

        def happen(run: Run) -> None:
            if run.stage is Stage.RETURN_TO_STAGING:
                began.append(run.simulation.time)
            run.simulation.set_fault(Fault.SILENT_BATTERY, silent and bool(began))

        limits = replace(defaults.timeouts, goal_timeout=goal_timeout, battery_lost_after=3.0)
        return Run(replace(defaults, timeouts=limits), (Fault.DEAD_CHARGER,), happen=happen).end(), began[0]

    outcome, began = run(0.0)
    if not silent:
        outcome, _ = run(began + 1.0)
    assert outcome.error_code is ErrorCode.FAILED_TO_CHARGE
    reason = "battery_lost_after" if silent else "goal_timeout"
    assert re.search(f"then, on the way back to the staging pose: .*{reason}", outcome.error_msg)


@pytest.mark.parametrize("stage", [Stage.CORRECTING, Stage.RETURN_TO_STAGING])
def test_a_cancel_ends_the_moves_at_once(stage: Stage) -> None:
    def happen(run: Run) -> None:
        if run.stage is stage and run.way.get(stage, 0.0) > 0.01:
            run.goal.cancel()

    run = Run(parameters(), (Fault.DEAD_CHARGER,), happen=happen)
    assert run.end().end is End.CANCELED
    assert run.stages[-1] is stage


@pytest.mark.parametrize("distance", [0.02, 0.03125, 0.08])
def test_a_press_ends_at_the_contacts_however_far_it_may_go_on(distance: float) -> None:
    tries = parameters(max_corrections=1, correction_distance=distance)
    tries = replace(tries, approach=replace(tries.approach, docking_overshoot=0.1))
    outcome = Run(tries, (Fault.DEAD_CHARGER,)).end()
    assert outcome.error_code is ErrorCode.FAILED_TO_CHARGE
    assert "blocked" not in f"{outcome.error_msg} {outcome.doubts}"


@settings(max_examples=8, derandomize=True, deadline=None)
@given(
    count=st.integers(0, 3),
    distance=st.floats(0.02, 0.08),
    angle=st.floats(0.0, 0.06),
    seed=st.integers(0, 10**6),
    stopped_after=st.one_of(st.none(), st.floats(0.0, 30.0)),
)
def test_corrections_are_bounded_and_nothing_moves_after_the_end(
    count: int, distance: float, angle: float, seed: int, stopped_after: float | None
) -> None:
    """Whatever the moves are, and whenever a stop comes: their number, their way and their place are bounded."""
    tries = parameters(max_corrections=count, correction_distance=distance, correction_angle=angle)

    def happen(run: Run) -> None:
        if stopped_after is not None and run.simulation.time >= stopped_after:
            run.goal.abort(ErrorCode.STOP_LATCHED, "a stop was latched")
        if run.stage is Stage.CORRECTING:
            assert run.simulation.robot.pose.distance_to(DOCKED) < distance + 0.05

    run = Run(tries, (Fault.DEAD_CHARGER,), seed=seed, happen=happen)
    outcome = run.end()
    corrections = run.stages.count(Stage.CORRECTING)
    assert corrections <= count
    assert run.way.get(Stage.CORRECTING, 0.0) <= corrections * (2.0 * distance + 0.05)
    if stopped_after is None:
        assert (outcome.error_code, corrections) == (ErrorCode.FAILED_TO_CHARGE, count)
        assert run.stages[-1] is Stage.RETURN_TO_STAGING
    else:
        assert outcome.error_code in {ErrorCode.STOP_LATCHED, ErrorCode.FAILED_TO_CHARGE}
