"""What the robot has run into it touches slowly the next time."""

import math
from dataclasses import replace
from random import Random

import pytest
from benchmarks.docking.trial import settings_of, simulation_of

from docking.core.geometry import Pose
from docking.goal.dock import Docking
from docking.goal.dock_memory import DockMemory
from docking.goal.engine import Goal
from docking.goal.hits import AROUND, KEPT_FOR, Hits
from docking.goal.outcome import Command
from docking.parameters import ControllerName
from docking.plans.registry import make_plan
from docking.simulation.obstacle import Obstacle
from docking.simulation.simulation import Simulation

SLOW = 0.045
"""In m/s: `v_linear_min`, and a little."""
NEXT = 0.3
"""In m: a hit that is nearer to the first one is at the same place."""


class Low(Obstacle):
    """An obstacle below the camera: it does not hide the marker."""

    def hides(self, x: float, y: float) -> bool:
        return False


def run(simulation: Simulation, memory: DockMemory) -> list[tuple[Pose, float]]:
    """Dock once: where the robot ran into something, and how fast."""
    settings = settings_of(ControllerName.DOCK_POSE)
    goal = Goal(make_plan(settings), Docking(settings.timeouts, memory), simulation.time)
    step, hits = goal.step(simulation.observe()), []
    while isinstance(step, Command):
        bumps, speed = simulation.bumps, abs(simulation.robot.velocity.linear_x)
        simulation.run(settings.control_period, step.velocity)
        if simulation.bumps > bumps:
            hits.append((simulation.robot.pose, speed))
        step = goal.step(simulation.observe())
    return hits


@pytest.mark.parametrize("seed", range(3))
def test_the_second_hit_at_a_place_is_slow_also_in_the_next_goal(seed: int) -> None:
    random, simulation, memory = Random(seed), simulation_of(ControllerName.DOCK_POSE, seed), DockMemory()
    another = Low(random.uniform(-0.3, -0.2), random.uniform(-0.03, 0.03), random.uniform(0.12, 0.18))
    simulation.settings = replace(simulation.settings, obstacles=(another,))
    hits = run(simulation, memory) + run(simulation, memory)
    assert len(hits) > 1
    for place, speed in hits[1:]:
        assert speed <= SLOW or place.distance_to(hits[0][0]) > NEXT


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
