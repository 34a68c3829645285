"""What the robot has run into it touches slowly the next time."""

import math
import re
from dataclasses import replace
from random import Random

import pytest
from benchmarks.docking.trial import settings_of, simulation_of

from docking.core.errors import ErrorCode
from docking.core.geometry import Pose
from docking.goal.dock import Docking
from docking.goal.dock_memory import DockMemory
from docking.goal.engine import Goal
from docking.goal.hits import AROUND, KEPT_FOR, Hits, describe
from docking.goal.outcome import Command
from docking.parameters import ControllerName
from docking.plans.registry import make_plan
from docking.simulation.dock import DOCKED
from docking.simulation.faults import Fault
from docking.simulation.obstacle import Obstacle
from docking.simulation.simulation import Simulation

SLOW = 0.045
"""In m/s: `v_linear_min`, and a little."""
NEXT = 0.3
"""In m: a hit that is nearer to the first one is at the same place."""


def run(
    simulation: Simulation,
    memory: DockMemory,
    noticed: list[Pose],
    retries: int = 3,
    controller: ControllerName = ControllerName.DOCK_POSE,
) -> list[tuple[float, float]]:
    """Dock once.

    Args:
        simulation: The robot.
        memory: Of its docking server.
        noticed: Where it stood when it was noticed that it is blocked; more are added.
        retries: At most.
        controller: How.

    Returns:
        How fast it ran into something, and how far that was from the nearest place that had been noticed before.
    """
    settings = settings_of(controller)
    settings = replace(settings, timeouts=replace(settings.timeouts, max_retries=retries))
    goal = Goal(make_plan(settings), Docking(settings.timeouts, memory), simulation.time)
    step, hits = goal.step(simulation.observe()), []
    while isinstance(step, Command):
        bumps, speed, before = simulation.bumps, abs(simulation.robot.velocity.linear_x), step.retries
        simulation.run(settings.control_period, step.velocity)
        place = simulation.robot.pose
        if simulation.bumps > bumps:
            hits.append((speed, min((place.distance_to(known) for known in noticed), default=math.inf)))
        step = goal.step(simulation.observe())
        if step.error_code is ErrorCode.BLOCKED and step.retries > before:
            noticed.append(place)
    return hits


@pytest.mark.parametrize("seed", range(3))
def test_the_second_hit_at_a_place_is_slow_also_in_the_next_goal(seed: int) -> None:
    random, simulation, memory = Random(seed), simulation_of(ControllerName.DOCK_POSE, seed), DockMemory()
    another = Obstacle(random.uniform(-0.3, -0.2), random.uniform(-0.03, 0.03), random.uniform(0.12, 0.18), low=True)
    simulation.settings = replace(simulation.settings, obstacles=(another,))
    noticed: list[Pose] = []
    hits = run(simulation, memory, noticed) + run(simulation, memory, noticed)
    assert len(hits) > 1
    assert all(speed <= SLOW for speed, _ in hits[1:])


@pytest.mark.parametrize("seed", range(40))
def test_wherever_something_round_stands_the_next_hit_there_is_slow(seed: int) -> None:
    random, simulation = Random(f"round {seed}"), simulation_of(ControllerName.DOCK_POSE, 1000 + seed)
    start, part = simulation.robot.pose, random.uniform(0.0, 0.7)
    x, y = DOCKED.x + part * (start.x - DOCKED.x), part * start.y + random.uniform(-0.1, 0.1)
    radius = min(random.uniform(0.03, 0.2), 0.9 * start.distance_to(Pose(x, y)) - simulation.robot.radius)
    simulation.settings = replace(simulation.settings, obstacles=(Obstacle(x, y, max(0.02, radius), low=True),))
    assert all(speed <= SLOW or far > NEXT for speed, far in run(simulation, DockMemory(), [], retries=1))


def test_a_place_that_odometry_takes_to_be_passed_is_slow_all_the_same() -> None:
    """The wheels slip while the robot pushes: here odometry has the place 6 cm behind it at the second hit."""
    simulation = simulation_of(ControllerName.INFRARED, 500021)
    simulation.set_fault(Fault.OCCUPIED_DOCK, True)
    first, *later = run(simulation, DockMemory(), [], retries=1, controller=ControllerName.INFRARED)
    assert first[0] > SLOW
    assert later
    assert all(speed <= SLOW for speed, _ in later)


@pytest.mark.parametrize("controller", [ControllerName.DOCK_POSE, ControllerName.INFRARED])
def test_the_error_says_where_another_robot_stands_on_the_dock(controller: ControllerName) -> None:
    simulation, settings = simulation_of(controller, 0), settings_of(controller)
    simulation.set_fault(Fault.OCCUPIED_DOCK, True)
    goal = Goal(make_plan(settings), Docking(settings.timeouts), simulation.time)
    step = goal.step(simulation.observe())
    while isinstance(step, Command):
        simulation.run(settings.control_period, step.velocity)
        step = goal.step(simulation.observe())
    assert step.error_code is ErrorCode.BLOCKED
    assert re.search(r"it was blocked 0\.(29|3\d) m before its docked pose and 0\.0\d m .* \(4 times\)", step.error_msg)


def test_odometry_that_jumps_has_run_into_nothing() -> None:
    simulation, settings = simulation_of(ControllerName.DOCK_POSE, 0), settings_of(ControllerName.DOCK_POSE)
    memory, jump = DockMemory(), Pose()
    goal = Goal(make_plan(settings), Docking(settings.timeouts, memory), simulation.time)
    step = goal.step(simulation.observe())
    while isinstance(step, Command) and step.retries == 0:
        simulation.run(settings.control_period, step.velocity)
        if step.velocity.linear_x > 0.1:
            jump = Pose(0.5)
        observation = simulation.observe()
        assert observation.odometry is not None
        odometry = replace(observation.odometry, pose=jump.compose(observation.odometry.pose))
        step = goal.step(replace(observation, odometry=odometry))
    assert "odometry jumped" in step.error_msg
    assert not any("it was blocked" in doubt for doubt in goal.doubts.sentences())
    assert all(memory.hits.distance(Pose(x), 0.0, 0.2) == math.inf for x in (-5.0, -1.0, 0.0))


def test_the_words_of_a_place() -> None:
    assert describe(Pose(1.0, 2.0), None) == "it was blocked"
    assert describe(Pose(0.7, -0.1), Pose(1.0)) == (
        "it was blocked 0.30 m before its docked pose and 0.10 m to the right of it"
    )
    assert describe(Pose(1.2, 0.1), Pose(1.0)) == (
        "it was blocked 0.20 m beyond its docked pose and 0.10 m to the left of it"
    )


def test_a_place_is_slow_on_the_way_to_it_and_is_forgotten_after_a_while() -> None:
    hits = Hits()
    hits.add(Pose(1.0), 5.0)
    assert hits.distance(Pose(), 0.0, 0.2) == pytest.approx(1.0 - AROUND)
    assert hits.distance(Pose(), 0.1, 0.2) == pytest.approx(0.9 - AROUND)
    assert hits.distance(Pose(0.9), 0.0, 0.2) == 0.0
    assert hits.distance(Pose(), 0.0, -0.2) == math.inf
    assert hits.distance(Pose(theta=math.pi), 0.0, -0.2) == pytest.approx(1.0 - AROUND)
    hits.forget(5.0 + KEPT_FOR)
    assert hits.distance(Pose(), 0.0, 0.2) < math.inf
    hits.forget(5.1 + KEPT_FOR)
    assert hits.distance(Pose(), 0.0, 0.2) == math.inf
