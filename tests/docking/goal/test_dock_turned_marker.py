"""Docking although the marker is turned on its dock: no place is touched twice."""

import math

import pytest

from docking.core.errors import ErrorCode
from docking.core.geometry import Pose
from docking.goal.dock import Docking
from docking.goal.engine import End, Goal, Outcome
from docking.parameters import ControllerName, DockSettings
from docking.plans.registry import make_plan
from docking.simulation.faults import Fault
from docking.simulation.marker import MarkerSettings
from docking.simulation.settings import Settings
from docking.simulation.simulation import Simulation


def dock(turned: float, *, dead: bool = False) -> tuple[Outcome, Simulation]:
    """One goal, with a marker that is turned by some degrees."""
    marker = MarkerSettings(angle_bias=math.radians(turned))
    simulation = Simulation(Settings(start=Pose(-1.3, 0.2, -0.1), marker=marker), 3)
    simulation.set_fault(Fault.DEAD_CHARGER, dead)
    docking = DockSettings(controller=ControllerName.DOCK_POSE)
    goal = Goal(make_plan(docking), Docking(docking.timeouts), 0.0)
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
