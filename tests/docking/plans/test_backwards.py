"""Docking and undocking backwards, in the simulation."""

import math
from random import Random

import pytest

from docking.core.errors import ErrorCode, Stage
from docking.core.geometry import Pose, normalize_angle
from docking.core.observation import STANDSTILL, Velocity
from docking.goal.behavior import Done
from docking.goal.dock import Docking
from docking.goal.dock_memory import DockMemory
from docking.goal.engine import Goal
from docking.goal.outcome import Command, End, Outcome
from docking.goal.undock import Undocking
from docking.parameters import ControllerName, Dock, DockDirection, DockSettings, DockTimeouts, UndockTimeouts
from docking.plans.registry import make_plan
from docking.plans.undock import UndockPlan
from docking.simulation.dock import DOCKED
from docking.simulation.dock import DockSettings as SimulatedDock
from docking.simulation.marker import MarkerSettings
from docking.simulation.settings import Settings
from docking.simulation.simulation import Simulation

PERIOD = 0.05
BACKED = DOCKED.compose(Pose(theta=math.pi))
DOCKS = {
    "rear camera": Dock(dock_direction=DockDirection.BACKWARD),
    "rotate_to_dock": Dock(dock_direction=DockDirection.BACKWARD, rotate_to_dock=True),
}
CAMERAS = {"rear camera": math.pi, "rotate_to_dock": 0.0}
both = pytest.mark.parametrize("way", list(DOCKS))


def world(way: str, start: Pose, seed: int) -> Simulation:
    settings = Settings(start=start, dock=SimulatedDock(at_back=True), marker=MarkerSettings(camera_yaw=CAMERAS[way]))
    return Simulation(settings, seed=seed)


def run(simulation: Simulation, goal: Goal, longest: float = 400.0) -> tuple[Outcome, list[Command]]:
    steps: list[Command] = []
    while simulation.time < longest:
        step = goal.step(simulation.observe())
        if isinstance(step, Outcome):
            simulation.run(1.0, STANDSTILL)
            return step, steps
        steps.append(step)
        simulation.run(PERIOD, step.velocity)
    raise AssertionError(f"still at {simulation.robot.pose}, {steps[-1]}")


def dock(simulation: Simulation, way: str) -> tuple[Outcome, list[Command]]:
    settings = DockSettings(controller=ControllerName.DOCK_POSE, dock=DOCKS[way])
    assert settings.find_conflict() is None
    goal = Goal(make_plan(settings), Docking(DockTimeouts()), simulation.time)
    return run(simulation, goal)


@both
def test_it_backs_onto_the_dock_from_anywhere_in_front(way: str) -> None:
    random = Random(5)
    retries = 0
    for seed in range(8):
        start = Pose(random.uniform(-2.2, -0.8), random.uniform(-0.7, 0.7), random.uniform(-math.pi, math.pi))
        simulation = world(way, start, seed)
        outcome, steps = dock(simulation, way)
        assert outcome.end is End.SUCCEEDED, (start, outcome)
        retries += outcome.retries
        assert simulation.contact
        assert simulation.robot.pose.distance_to(BACKED) < 0.02
        assert abs(normalize_angle(simulation.robot.theta - BACKED.theta)) < math.radians(5.0)
        approach = [step.velocity.linear_x for step in steps if step.stage is Stage.CONTROLLING]
        assert max(approach) <= 0.0
        assert min(approach) >= -0.6 * 0.26 - 1e-9
    assert retries <= 3


@both
def test_the_poses_are_those_of_base_link(way: str) -> None:
    simulation = world(way, Pose(-1.3, 0.1, math.pi if way == "rear camera" else 0.0), 3)
    _, steps = dock(simulation, way)
    told = [step for step in steps if step.stage is Stage.CONTROLLING][-1]
    assert told.filtered_dock_pose is not None
    assert told.staging_pose is not None
    error = told.filtered_dock_pose.relative_to(simulation.odometry.pose)
    assert error.distance_to(Pose()) < 0.05
    assert abs(error.theta) < 0.15
    turned = normalize_angle(told.staging_pose.theta - told.filtered_dock_pose.theta)
    assert abs(turned) == pytest.approx(0.0 if way == "rear camera" else math.pi, abs=1e-6)


@pytest.mark.parametrize("turned", [False, True])
@both
def test_it_backs_off_away_from_the_dock_whether_it_has_turned_round_or_not(way: str, turned: bool) -> None:
    simulation = world(way, Pose(-0.5, theta=CAMERAS[way]), 3)
    plan = make_plan(DockSettings(controller=ControllerName.DOCK_POSE, dock=DOCKS[way]))
    while simulation.time < 6.0:
        simulation.run(PERIOD, Velocity(0.0, 1.0 if turned and 2.0 < simulation.time < 2.0 + math.pi else 0.0))
        plan.observe(simulation.observe())
    back_off = plan.controller(Stage.RETRY)
    while isinstance(step := back_off.step(simulation.observe(), PERIOD), Velocity):
        simulation.run(PERIOD, step)
        plan.observe(simulation.observe())
    assert isinstance(step, Done)
    assert simulation.robot.pose.distance_to(Pose(-0.9)) < 0.1


@both
def test_where_the_dock_is_not_known_it_backs_off_from_where_it_looks(way: str) -> None:
    simulation = world(way, Pose(-0.5), 3)
    back_off = make_plan(DockSettings(controller=ControllerName.DOCK_POSE, dock=DOCKS[way])).controller(Stage.RETRY)
    step = back_off.step(simulation.observe(), PERIOD)
    assert isinstance(step, Velocity)
    assert math.cos(CAMERAS[way]) * step.linear_x < 0.0


def test_a_camera_that_looks_ahead_needs_rotate_to_dock() -> None:
    settings = Settings(start=Pose(-1.3), dock=SimulatedDock(at_back=True))
    outcome, _ = dock(Simulation(settings, seed=1), "rear camera")
    assert (outcome.end, outcome.error_code) == (End.ABORTED, ErrorCode.LOST_MARKER)


def test_a_robot_that_docked_backwards_undocks_forwards() -> None:
    settings = Settings(start=BACKED, dock=SimulatedDock(at_back=True))
    simulation = Simulation(settings, seed=4)
    simulation.run(1.0)
    assert simulation.charging
    staging = DOCKS["rotate_to_dock"]
    plan = UndockPlan(staging.distance, DockSettings().motion, forwards=staging.backward)
    outcome, steps = run(simulation, Goal(plan, Undocking(UndockTimeouts(), DockMemory()), simulation.time))
    assert outcome == Outcome(End.SUCCEEDED)
    assert not simulation.charging
    assert simulation.bumps == 0
    assert min(step.velocity.linear_x for step in steps) >= 0.0
    assert simulation.robot.pose.distance_to(Pose(-0.9)) < 0.05


@pytest.mark.parametrize(
    ("settings", "conflict"),
    [
        (
            DockSettings(controller=ControllerName.DOCK_POSE, dock=Dock(rotate_to_dock=True)),
            "rotate_to_dock is true, but dock_direction is not backward",
        ),
        (
            DockSettings(controller=ControllerName.INFRARED.value, dock=DOCKS["rear camera"]),  # as a node has it
            "dock_direction is backward, but infrared docks forwards only: its receivers look ahead",
        ),
        (
            DockSettings(
                controller=ControllerName.DOCK_POSE,
                dock=DOCKS["rear camera"],
                timeouts=DockTimeouts(dock_approach_timeout=5.0),
            ),
            (
                "dock_approach_timeout (5 s) is too short: 0.6 m at 0.156 m/s (0.6 of v_linear_max)"
                " and 0.1 m at 0.04 m/s (v_linear_min) takes 6.3 s"
            ),
        ),
    ],
)
def test_what_cannot_work_is_refused(settings: DockSettings, conflict: str) -> None:
    assert settings.find_conflict() == conflict
