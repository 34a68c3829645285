"""Backwards the robot is slow, whatever moves it, unless a scan shows what is behind it."""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from benchmarks.docking.cases import CASES, Case
from benchmarks.docking.trial import settings_of, simulation_of
from hypothesis import given, settings
from hypothesis import strategies as st

from docking.core.geometry import Pose
from docking.core.observation import STANDSTILL, Observation, Odometry, Scan, Velocity
from docking.estimation.motion_model import MotionModel
from docking.goal.dock import Docking
from docking.goal.engine import Goal
from docking.goal.obstacle_watch import ObstacleWatch, watch_obstacles
from docking.goal.outcome import Command
from docking.goal.pace import Pace
from docking.goal.plan import KnownPoses
from docking.goal.undock import Undocking
from docking.parameters import CollisionSettings, ControllerName, DockSettings, UndockTimeouts
from docking.plans.registry import make_plan
from docking.plans.undock import UndockPlan
from docking.simulation.faults import Fault
from docking.simulation.room import WORKSHOP
from docking.simulation.simulation import Simulation

LIMITS = DockSettings().motion
SQUARE = ((0.2, 0.2), (-0.2, 0.2), (-0.2, -0.2), (0.2, -0.2))
BLIND = [(controller, case) for case in CASES for controller in case.controllers if case.search_radius == 0.0]
FAULTS = [Fault.STUCK_WHEEL, Fault.DEAD_CHARGER, Fault.OCCLUDED_MARKER, Fault.HIDDEN_BEACON]


def fastest_back(
    simulation: Simulation, goal: Goal, longest: float, happen: Callable[[float], None] = lambda now: None
) -> float:
    """The highest speed backwards that was commanded, in m/s."""
    fastest, step = 0.0, goal.step(simulation.observe())
    while isinstance(step, Command) and simulation.time < longest:
        happen(simulation.time)
        fastest = max(fastest, -step.velocity.linear_x)
        simulation.run(0.05, step.velocity)
        step = goal.step(simulation.observe())
    return fastest


@settings(max_examples=8, deadline=None)
@given(
    st.sampled_from(BLIND),
    st.integers(0, 10**6),
    st.sampled_from(FAULTS),
    st.floats(2.0, 40.0),
    st.floats(1.0, 8.0),
)
def test_without_a_scan_no_plan_drives_back_fast(
    job: tuple[ControllerName, Case], seed: int, fault: Fault, begin: float, length: float
) -> None:
    """Whatever is wrong with the robot, and whatever makes it retry."""
    controller, case = job
    simulation, docking = simulation_of(controller, seed, case), settings_of(controller, case)
    goal = Goal(make_plan(docking), Docking(docking.timeouts, recovery=docking.recovery), 0.0)
    back = fastest_back(simulation, goal, 90.0, lambda now: simulation.set_fault(fault, begin < now < begin + length))
    assert back <= max(LIMITS.v_linear_back, 1.4 * simulation.settings.robot.linear_dead_zone) + 1e-9


@pytest.mark.parametrize("seed", range(3))
def test_a_robot_that_has_come_too_near_backs_to_its_staging_pose_slowly(seed: int) -> None:
    docking = settings_of(ControllerName.DOCK_POSE)
    simulation = simulation_of(ControllerName.DOCK_POSE, seed)
    simulation.place(Pose(-0.5, 0.1, -0.1))
    goal = Goal(make_plan(docking), Docking(docking.timeouts), 0.0)
    assert fastest_back(simulation, goal, 60.0) == pytest.approx(LIMITS.v_linear_back)


def test_undocking_is_slow() -> None:
    simulation = simulation_of(ControllerName.DOCK_POSE, 0)
    simulation.place(Pose(-0.2))
    goal = Goal(UndockPlan(0.7, LIMITS), Undocking(UndockTimeouts(), assume_docked=True), 0.0)
    assert fastest_back(simulation, goal, 60.0) == pytest.approx(LIMITS.v_linear_back)


def test_with_a_scan_of_what_is_behind_it_may_back_as_fast_as_it_drives() -> None:
    docking = settings_of(ControllerName.DOCK_POSE)
    docking = replace(docking, collision=replace(docking.collision, use_collision_detection=True))
    world = simulation_of(ControllerName.DOCK_POSE, 1).settings
    simulation = Simulation(replace(world, room=WORKSHOP, start=Pose(-0.35)), 1)
    simulation.scanning = True
    goal = Goal(make_plan(docking), Docking(docking.timeouts), 0.0, watch_obstacles(docking))
    assert fastest_back(simulation, goal, 60.0) > LIMITS.v_linear_back + 0.05


def walls(begin: float, end: float) -> Scan:
    """What a scanner with a view from one angle to another sees of walls, in rad from straight ahead."""
    angles = np.radians(np.arange(begin, end, 2.0))
    return Scan(2.0 * np.column_stack((np.cos(angles), np.sin(angles))), 0.0)


@pytest.mark.parametrize(
    ("scan", "sees"),
    [
        (walls(-180.0, 180.0), True),
        (walls(140.0, 220.0), True),
        (walls(-135.0, 135.0), False),
        (walls(-135.0, 172.0), False),
        (Scan(np.zeros((0, 2)), 0.0), False),
        (Scan(np.array(((-0.1, 0.0), (-0.1, 0.04), (-0.1, -0.04))), 0.0), False),
    ],
    ids=["all around", "behind", "270 degrees", "one side", "nothing in range", "the robot itself"],
)
@pytest.mark.parametrize("heading", [0.0, 2.0])
def test_a_scan_shows_what_is_behind_where_it_ends_at_something_there(scan: Scan, sees: bool, heading: float) -> None:
    watch = ObstacleWatch(CollisionSettings(use_collision_detection=True), SQUARE)
    assert not watch.sees_behind
    cos, sin = math.cos(heading), math.sin(heading)
    turned = Scan(scan.points @ np.array(((cos, sin), (-sin, cos))), scan.stamp)
    odometry = Odometry(Pose(theta=heading), STANDSTILL, 0.0)
    watch.check(Observation(0.0, odometry=odometry, scan=turned), None, 0.05)
    assert watch.sees_behind is sees
    watch.check(Observation(1.0, odometry=odometry, scan=turned), None, 0.05)
    assert not watch.sees_behind, "an old scan shows nothing"


@settings(max_examples=200)
@given(
    st.lists(st.tuples(st.floats(-0.5, 0.5), st.floats(-2.0, 2.0), st.floats(0.0, 0.3)), max_size=60),
    st.booleans(),
)
def test_whatever_a_behavior_asks_for(steps: list[tuple[float, float, float]], known: bool) -> None:
    pace, model, now, pose = Pace(LIMITS, 0.06), MotionModel(), 0.0, Pose()
    poses = KnownPoses(Pose(1.0), Pose(1.0), Pose(0.3)) if known else KnownPoses()
    for linear, angular, dt in steps:
        now += dt
        model.update(now, pose)
        velocity = pace.next(Velocity(linear, angular), dt, pose, poses, model)
        pose = pose.compose(Pose(velocity.linear_x * dt, 0.0, velocity.angular_z * dt))
        model.commanded = velocity
        assert velocity.linear_x >= -LIMITS.v_linear_back - 1e-9
