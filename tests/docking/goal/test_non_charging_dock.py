"""Docks that do not charge: what docks and undocks there is the pose, and no battery is needed."""

from dataclasses import replace

import pytest

from docking.core.errors import ErrorCode, Stage
from docking.core.geometry import Pose
from docking.goal.dock_memory import DockMemory
from docking.goal.engine import Goal
from docking.goal.outcome import End, Outcome
from docking.nodes.dock_server import DockAction
from docking.nodes.undock_server import UndockAction
from docking.parameters import ChargingSettings, ChargingSource, ControllerName, DockSettings, UndockSettings
from docking.simulation.faults import Fault
from docking.simulation.settings import Settings
from docking.simulation.simulation import Simulation

NONE = ChargingSettings(charging_source=ChargingSource.NONE)
STARTS = {ControllerName.DOCK_POSE: Pose(-1.0, 0.1, -0.1), ControllerName.INFRARED: Pose(-0.8, -0.2, 0.2)}


def run(simulation: Simulation, goal: Goal) -> tuple[Outcome, list[Stage]]:
    stages: list[Stage] = []
    while not isinstance(step := goal.step(simulation.observe()), Outcome):
        if step.stage not in stages[-1:]:
            stages.append(step.stage)
        simulation.run(0.05, step.velocity)
    return step, stages


@pytest.mark.parametrize("controller", list(STARTS))
def test_it_docks_and_undocks_without_a_charge_and_without_a_battery(controller: ControllerName) -> None:
    simulation, memory = Simulation(Settings(start=STARTS[controller]), 3), DockMemory()
    simulation.set_fault(Fault.DEAD_CHARGER, True)
    simulation.measurement = None
    simulation.set_fault(Fault.SILENT_BATTERY, True)
    settings = DockSettings(controller=controller, charging=NONE)
    outcome, stages = run(simulation, DockAction().make_goal(settings, memory, 0.0))
    assert outcome == Outcome(End.SUCCEEDED)
    assert stages[-1] is Stage.WAIT_FOR_CHARGE
    assert Stage.WAIT_FOR_BATTERY not in stages
    assert Stage.CORRECTING not in stages
    assert simulation.contact
    again, _ = run(simulation, DockAction().make_goal(settings, memory, simulation.time))
    assert again == Outcome(End.SUCCEEDED)
    assert simulation.presses == 1, "it was docked already"
    left, stages = run(simulation, UndockAction().make_goal(UndockSettings(), memory, simulation.time))
    assert left == Outcome(End.SUCCEEDED)
    assert stages == [Stage.UNDOCKING]
    assert simulation.robot.x < -0.8


def test_who_is_pushed_away_before_it_counts_is_not_docked() -> None:
    simulation = Simulation(Settings(start=STARTS[ControllerName.DOCK_POSE]), 3)
    settings = DockSettings(controller=ControllerName.DOCK_POSE, charging=NONE)
    settings = replace(settings, timeouts=replace(settings.timeouts, max_retries=0, charge_stable_for=2.0))
    goal, pushed = DockAction().make_goal(settings, DockMemory(), 0.0), False
    while not isinstance(step := goal.step(simulation.observe()), Outcome):
        if step.stage is Stage.WAIT_FOR_CHARGE and not pushed:
            pushed = True
            simulation.push(Pose(-0.15))
        simulation.run(0.05, step.velocity)
    assert step.error_code in {ErrorCode.PUSHED_OFF, ErrorCode.FAILED_TO_CONTROL}
