"""Docking although the marker is turned on its dock: no place is touched twice."""

import math

import pytest

from docking.core.errors import ErrorCode
from docking.core.geometry import Pose
from docking.goal.dock_memory import DockMemory
from docking.goal.outcome import End, Outcome
from docking.nodes.dock_server import DockAction
from docking.parameters import ControllerName, DockSettings, RecoverySettings
from docking.simulation.faults import Fault
from docking.simulation.marker import MarkerSettings
from docking.simulation.settings import Settings
from docking.simulation.simulation import Simulation


def dock(turned: float, *, dead: bool = False, memory: DockMemory | None = None) -> tuple[Outcome, Simulation]:
    """One goal, with a marker that is turned by some degrees."""
    marker = MarkerSettings(angle_bias=math.radians(turned))
    simulation = Simulation(Settings(start=Pose(-1.3, 0.2, -0.1), marker=marker), 3)
    simulation.set_fault(Fault.DEAD_CHARGER, dead)
    docking = DockSettings(controller=ControllerName.DOCK_POSE, recovery=RecoverySettings(max_corrections=0))
    goal = DockAction().make_goal(docking, memory or DockMemory(), 0.0)
    while not isinstance(step := goal.step(simulation.observe()), Outcome):
        simulation.run(docking.control_period, step.velocity)
    return step, simulation


@pytest.mark.parametrize("turned", [6.0, -6.0])
def test_a_marker_that_is_turned_is_docked_at_after_a_retry_elsewhere(turned: float) -> None:
    outcome, simulation = dock(turned)
    assert outcome.end is End.SUCCEEDED
    assert simulation.contact
    assert 1 <= outcome.retries <= 3


def test_a_dead_charger_ends_with_the_advice_to_calibrate_after_three_arrivals_on_the_contacts() -> None:
    outcome, simulation = dock(0.0, dead=True)
    assert (outcome.end, outcome.error_code, outcome.retries) == (End.ABORTED, ErrorCode.FAILED_TO_CHARGE, 3)
    assert outcome.error_msg.endswith("call calibrate_dock")
    assert simulation.bumps == 0


@pytest.mark.parametrize("turned", [6.0, -6.0])
def test_the_next_goal_does_not_touch_the_dock_where_the_last_one_did_in_vain(turned: float) -> None:
    memory = DockMemory()
    first, _ = dock(turned, memory=memory)
    second, simulation = dock(turned, memory=memory)
    assert first.retries > 0
    assert (second.end, second.retries) == (End.SUCCEEDED, 0)
    assert simulation.bumps == 0
