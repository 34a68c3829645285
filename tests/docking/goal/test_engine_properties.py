"""What holds for every controller, whatever the robot is told and wherever it starts."""

import math
from dataclasses import replace
from random import Random

import pytest
from benchmarks.docking.cases import CASES, Case
from benchmarks.docking.trial import DROP_OUTS, REGIONS, settings_of, simulation_of
from hypothesis import example, given, settings
from hypothesis import strategies as st

from docking.core.battery import BatteryReading
from docking.core.errors import ErrorCode, Stage
from docking.core.geometry import Pose, normalize_angle
from docking.core.observation import (
    STANDSTILL,
    InfraredReading,
    MarkerDetection,
    Observation,
    Odometry,
    Velocity,
)
from docking.goal.dock import Docking
from docking.goal.engine import Goal
from docking.goal.motion_watch import DELAY, REPORTED_AFTER
from docking.goal.outcome import Command, End, Outcome
from docking.goal.undock import Undocking
from docking.parameters import ControllerName, UndockTimeouts
from docking.plans.registry import make_plan
from docking.plans.undock import UndockPlan
from docking.simulation.marker import MarkerSettings
from docking.simulation.settings import Settings
from docking.simulation.simulation import Simulation

CONTROLLERS = list(REGIONS)
NUMBERS = st.one_of(st.floats(-5.0, 5.0), st.floats(allow_nan=True, allow_infinity=True))
STAMPS = st.one_of(st.floats(-1.0, 1.0), st.sampled_from([0.0, math.nan, math.inf, -math.inf]))
ANY_POSES = st.builds(Pose, NUMBERS, NUMBERS, NUMBERS)
ANY_VELOCITIES = st.builds(Velocity, NUMBERS, NUMBERS)


@st.composite
def anything(draw: st.DrawFn) -> tuple[float, Observation]:
    """A pause, and what is known after it, with stamps that count from the moment."""
    pause = draw(st.sampled_from([0.0, 0.02, 0.05, 0.1, 0.5, 3.0]))
    return pause, Observation(
        0.0,
        draw(st.one_of(st.none(), st.builds(BatteryReading, st.sampled_from([0, 2, 3, 77]), STAMPS))),
        draw(st.one_of(st.none(), st.builds(Odometry, ANY_POSES, ANY_VELOCITIES, STAMPS))),
        draw(st.one_of(st.none(), st.builds(MarkerDetection, ANY_POSES, STAMPS))),
        draw(st.one_of(st.none(), st.builds(InfraredReading, NUMBERS, NUMBERS, NUMBERS, STAMPS))),
    )


def at(now: float, known: Observation, odometry: Pose) -> Observation:
    """The same at a moment; odometry that makes sense now and then, so that the robot gets to drive."""
    told = known.odometry
    return Observation(
        now,
        BatteryReading(3, now)
        if known.battery is None
        else BatteryReading(3, now + min(0.0, known.battery.received_at)),
        Odometry(odometry, STANDSTILL, now) if told is None else Odometry(told.pose, told.velocity, now + told.stamp),
        known.marker and MarkerDetection(known.marker.pose, now + known.marker.stamp),
        known.infrared
        and InfraredReading(
            known.infrared.left, known.infrared.center, known.infrared.right, now + known.infrared.stamp
        ),
    )


@pytest.mark.parametrize("controller", CONTROLLERS)
@given(st.lists(anything(), min_size=1, max_size=40))
def test_whatever_is_observed_velocities_are_numbers_within_their_limits(
    controller: ControllerName, known: list[tuple[float, Observation]]
) -> None:
    docking = settings_of(controller)
    goal, now, last, ended = Goal(make_plan(docking), Docking(docking.timeouts), 0.0), 0.0, STANDSTILL, None
    for pause, observation in known:
        now += pause
        told = at(now, observation, Pose(0.01 * now, 0.0, 0.1 * math.sin(now)))
        step = goal.step(told)
        if ended is not None:
            assert step is ended
        if isinstance(step, Outcome):
            assert step.end is End.ABORTED
            ended = step
            continue
        assert isinstance(step, Command)
        assert step.velocity.finite
        assert abs(step.velocity.linear_x) <= docking.motion.v_linear_max
        assert abs(step.velocity.angular_z) <= docking.motion.v_angular_max
        if step.velocity != STANDSTILL:
            assert told.odometry is not None
            assert now - told.odometry.stamp <= DELAY
            assert abs(step.velocity.linear_x - last.linear_x) <= docking.motion.a_linear_max * pause + 1e-9
            assert abs(step.velocity.angular_z - last.angular_z) <= docking.motion.a_angular_max * pause + 1e-9
        last = step.velocity


@pytest.mark.parametrize("controller", CONTROLLERS)
@settings(max_examples=6, derandomize=True)
@given(
    distance=st.floats(0.0, 1.0), aside=st.floats(-1.0, 1.0), turned=st.floats(-1.0, 1.0), seed=st.integers(0, 10**6)
)
@example(distance=1.0, aside=1.0, turned=1.0, seed=0)
@example(distance=1.0, aside=-1.0, turned=1.0, seed=0)
@example(distance=0.0, aside=1.0, turned=-1.0, seed=0)
@example(distance=0.0, aside=-1.0, turned=-1.0, seed=0)
def test_it_docks_from_everywhere_in_its_region(
    controller: ControllerName, distance: float, aside: float, turned: float, seed: int
) -> None:
    region = REGIONS[controller]
    away = region.nearest + distance * (region.farthest - region.nearest)
    x, y = -away * math.cos(aside * region.off), away * math.sin(aside * region.off)
    start = Pose(x, y, normalize_angle(math.atan2(-y, -x) + turned * region.off))
    simulation = Simulation(Settings(start=start, marker=MarkerSettings(drop_outs=DROP_OUTS)), seed)
    docking = settings_of(controller)
    goal = Goal(make_plan(docking), Docking(docking.timeouts), 0.0)
    step = goal.step(simulation.observe())
    while isinstance(step, Command):
        simulation.run(docking.control_period, step.velocity)
        step = goal.step(simulation.observe())
    assert step.end is End.SUCCEEDED
    assert simulation.contact
    assert simulation.bumps == 0


@pytest.mark.parametrize(("controller", "far_off"), [(ControllerName.DOCK_POSE, 0.05), (ControllerName.INFRARED, 0.3)])
@settings(max_examples=8, derandomize=True)
@given(
    distance=st.floats(0.45, 3.0),
    bearing=st.floats(-math.pi, math.pi),
    turned=st.floats(-math.pi, math.pi),
    faults=st.lists(st.sampled_from([case for case in CASES if case.disturb is CASES[0].disturb]), max_size=3),
    seed=st.integers(0, 10**6),
)
def test_whatever_is_wrong_with_the_robot_it_is_never_fast_and_ends_at_rest(
    *,
    controller: ControllerName,
    far_off: float,
    distance: float,
    bearing: float,
    turned: float,
    faults: list[Case],
    seed: int,
) -> None:
    """From any start, seen or not, with any faults: it touches the dock only slowly, and near its contacts."""
    random, docking = Random(seed), settings_of(controller)
    world = Settings(start=Pose(-distance * math.cos(bearing), distance * math.sin(bearing), turned))
    for fault in faults:
        world = fault.change(world, random)
    jitter = max((fault.jitter for fault in faults), default=0.0)
    simulation, motion = Simulation(world, seed), docking.motion
    goal, period, last = Goal(make_plan(docking), Docking(docking.timeouts), 0.0), docking.control_period, STANDSTILL
    step = goal.step(simulation.observe())
    while isinstance(step, Command):
        velocity, bumps, driven = step.velocity, simulation.bumps, simulation.robot.velocity
        assert max(abs(velocity.linear_x), abs(driven.linear_x)) <= motion.v_linear_max + 1e-9
        assert max(abs(velocity.angular_z), abs(driven.angular_z)) <= motion.v_angular_max + 1e-9
        if velocity != STANDSTILL:
            assert abs(velocity.linear_x - last.linear_x) <= motion.a_linear_max * period + 1e-9
            assert abs(velocity.angular_z - last.angular_z) <= motion.a_angular_max * period + 1e-9
        last, period = velocity, docking.control_period * (1.0 + random.uniform(-jitter, jitter))
        simulation.run(period, velocity)
        if simulation.bumps > bumps:
            assert abs(driven.linear_x) < 0.1
            assert abs(simulation.robot.y) < far_off
        step = goal.step(simulation.observe())
        assert simulation.time < 600.0
    assert step.end in {End.SUCCEEDED, End.ABORTED}
    assert (step.end is End.SUCCEEDED) is (step.error_code is ErrorCode.NONE)
    if step.end is End.SUCCEEDED:
        assert simulation.contact
    simulation.run(2.0, STANDSTILL)
    assert simulation.robot.velocity == STANDSTILL


@pytest.mark.parametrize("controller", CONTROLLERS)
@settings(max_examples=6, derandomize=True)
@given(
    silences=st.lists(st.tuples(st.floats(0.5, 15.0), st.floats(0.05, 6.0)), min_size=1, max_size=4),
    seed=st.integers(0, 10**6),
)
@example(silences=[(5.0, 4.8), (5.0, 5.5)], seed=0)
def test_without_odometry_it_stands_and_goes_on_unless_that_takes_too_long(
    controller: ControllerName, silences: list[tuple[float, float]], seed: int
) -> None:
    """Odometry comes for a while, and then stops for another, several times."""
    docking, simulation = settings_of(controller), simulation_of(controller, seed)
    goal = Goal(make_plan(docking), Docking(docking.timeouts), 0.0)
    period, now, spans = docking.control_period, 0.0, []
    for comes_for, silence in silences:
        spans.append((now + comes_for, now + comes_for + silence))
        now += comes_for + silence
    last = simulation.observe().odometry
    while True:
        observation = simulation.observe()
        silent = any(begin <= observation.now < end for begin, end in spans)
        last = last if silent else observation.odometry
        assert last is not None
        step = goal.step(replace(observation, odometry=last))
        if isinstance(step, Outcome):
            break
        silence = observation.now - last.stamp
        assert silence <= DELAY or step.velocity == STANDSTILL
        assert (step.stage is Stage.WAIT_FOR_ODOMETRY) is (step.error_code is ErrorCode.ODOMETRY_LOST)
        assert step.stage is not Stage.WAIT_FOR_ODOMETRY or silence > REPORTED_AFTER
        simulation.run(period, step.velocity)
    if step.error_code is ErrorCode.ODOMETRY_LOST:
        assert observation.now - last.stamp > docking.timeouts.odometry_timeout
    else:
        assert step.end is End.SUCCEEDED
        assert simulation.contact
    assert simulation.bumps == 0


@settings(max_examples=8, derandomize=True)
@given(seed=st.integers(0, 10**6))
def test_it_docks_although_some_detections_are_nonsense(seed: int) -> None:
    """One in seven is somewhere else, turned round, or no number."""
    random = Random(seed)
    simulation = simulation_of(ControllerName.DOCK_POSE, seed)
    docking = settings_of(ControllerName.DOCK_POSE)
    goal = Goal(make_plan(docking), Docking(docking.timeouts), 0.0)
    told: MarkerDetection | None = None
    while True:
        observation = simulation.observe()
        marker = observation.marker
        if marker is not None and (told is None or marker.stamp > told.stamp):
            told = MarkerDetection(random.choice(nonsense(marker.pose)), marker.stamp)
        step = goal.step(replace(observation, marker=told))
        if isinstance(step, Outcome):
            break
        simulation.run(docking.control_period, step.velocity)
    assert step.end is End.SUCCEEDED
    assert simulation.contact


def nonsense(pose: Pose) -> list[Pose]:
    """The truth, most of the time, and what a detector may take for it."""
    wrong = [Pose(pose.x + 1.0, pose.y - 0.5, pose.theta), Pose(pose.x, pose.y, pose.theta + 1.0), Pose(math.nan)]
    return [pose] * 18 + wrong


@pytest.mark.parametrize("objective", ["dock", "undock"])
@given(st.lists(st.tuples(anything(), st.sampled_from([0, 1, 2, 3, 4, 77])), min_size=1, max_size=40))
def test_whatever_the_battery_tells_there_is_one_outcome_and_no_motion_after_it(
    objective: str, known: list[tuple[tuple[float, Observation], int]]
) -> None:
    docking = settings_of(ControllerName.DOCK_POSE)
    goal = (
        Goal(make_plan(docking), Docking(docking.timeouts), 0.0)
        if objective == "dock"
        else Goal(UndockPlan(0.7, docking.motion), Undocking(UndockTimeouts()), 0.0)
    )
    now, charged, ended = 0.0, False, None
    for (pause, observation), status in known:
        now += pause
        told = at(now, observation, Pose())
        assert told.battery is not None
        charged |= status in {1, 4}
        step = goal.step(replace(told, battery=replace(told.battery, status=status)))
        if ended is not None:
            assert step is ended
        elif isinstance(step, Outcome):
            ended = step
            assert charged or step.end is End.ABORTED  # neither goal succeeds where nothing ever told of a charger
        else:
            assert abs(step.velocity.linear_x) <= docking.motion.v_linear_max
            assert objective == "dock" or charged or step.velocity == STANDSTILL
