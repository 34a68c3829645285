"""A robot whose localization is far off, such as one that was switched on at its dock: it undocks, and docks again."""

import math
from dataclasses import replace

import pytest

from docking.core.geometry import Pose
from docking.core.observation import STANDSTILL, Observation
from docking.goal.dock import Docking
from docking.goal.dock_memory import DockMemory
from docking.goal.engine import Goal
from docking.goal.outcome import Command, End, Outcome
from docking.goal.undock import Undocking
from docking.parameters import ControllerName, DockSettings, UndockSettings
from docking.plans.registry import make_plan
from docking.plans.undock import UndockPlan
from docking.simulation.dock import DOCKED
from docking.simulation.localization import LocalizationSettings
from docking.simulation.settings import Settings
from docking.simulation.simulation import Simulation

DOCKING, UNDOCKING = DockSettings(controller=ControllerName.DOCK_POSE), UndockSettings()
OFF = 0.8
TURNED = math.radians(20.0)


def _observe(simulation: Simulation) -> Observation:
    located = simulation.located_docked
    return replace(simulation.observe(), expected_dock=located, localized_at=simulation.time)


def _run(goal: Goal, simulation: Simulation) -> Outcome:
    step = goal.step(_observe(simulation))
    while isinstance(step, Command):
        simulation.run(DOCKING.control_period, step.velocity)
        step = goal.step(_observe(simulation))
        assert simulation.time < 600.0
    simulation.run(1.0, STANDSTILL)
    return step


def _dock(simulation: Simulation, memory: DockMemory) -> Goal:
    return Goal(make_plan(DOCKING), Docking(DOCKING.timeouts, memory), simulation.time)


@pytest.mark.parametrize("direction", range(0, 360, 60))
def test_a_robot_that_starts_on_its_dock_undocks_and_docks_whatever_the_map_says(direction: int) -> None:
    way = math.radians(direction)
    turned = TURNED if direction % 120 else -TURNED
    off = LocalizationSettings(error_x=OFF * math.cos(way), error_y=OFF * math.sin(way), error_yaw=turned)
    simulation, memory = Simulation(Settings(start=DOCKED, localization=off)), DockMemory()
    undocking = Undocking(UNDOCKING.timeouts, memory)
    outcome = _run(Goal(UndockPlan(0.7, UNDOCKING.motion), undocking, simulation.time), simulation)
    assert outcome.end is End.SUCCEEDED
    assert simulation.robot.pose.relative_to(DOCKED).x == pytest.approx(-0.7, abs=0.1)
    assert abs(simulation.robot.y) < 0.03
    assert _run(_dock(simulation, memory), simulation).end is End.SUCCEEDED
    assert simulation.contact
    assert simulation.bumps == 0


@pytest.mark.parametrize("slid", [Pose(-0.05), Pose(-0.03, 0.03), Pose(-0.15, 0.02, 0.1)])
def test_a_robot_that_has_slid_off_its_contacts_docks_again(slid: Pose) -> None:
    simulation, memory = Simulation(Settings(start=Pose(-1.0))), DockMemory()
    assert _run(_dock(simulation, memory), simulation).end is End.SUCCEEDED
    simulation.push(slid)
    simulation.run(2.0)
    assert not simulation.charging
    assert _run(_dock(simulation, memory), simulation).end is End.SUCCEEDED
    assert simulation.contact
    assert simulation.bumps == 0
    assert all(touch.speed <= DOCKING.motion.v_linear_min + 1e-9 for touch in simulation.touches)
