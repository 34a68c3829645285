"""Docking with a camera that sees nothing near."""

from dataclasses import replace

import pytest

from docking.core.errors import ErrorCode
from docking.core.geometry import Pose
from docking.goal.dock_memory import DockMemory
from docking.goal.outcome import End, Outcome
from docking.nodes.dock_server import DockAction
from docking.parameters import ControllerName, DockSettings
from docking.simulation.marker import MarkerSettings
from docking.simulation.settings import Settings
from docking.simulation.simulation import Simulation


def dock(nearest: float, seed: int, blind_distance: float | None = None) -> tuple[Outcome, Simulation]:
    """One goal, with a camera that does not detect a marker that is nearer than this, in m."""
    settings = DockSettings(controller=ControllerName.DOCK_POSE)
    if blind_distance is not None:
        settings = replace(settings, approach=replace(settings.approach, blind_distance=blind_distance))
    simulation = Simulation(Settings(start=Pose(-1.3, 0.2, -0.1), marker=MarkerSettings(range_min=nearest)), seed)
    goal = DockAction().make_goal(settings, DockMemory(), 0.0)
    while not isinstance(step := goal.step(simulation.observe()), Outcome):
        simulation.run(settings.control_period, step.velocity)
    return step, simulation


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("nearest", [0.2, 0.25, 0.3])
def test_the_last_part_is_driven_by_odometry_where_the_dock_goes_out_of_sight_twice_at_the_same_place(
    nearest: float, seed: int
) -> None:
    outcome, simulation = dock(nearest, seed)
    assert (outcome.end, simulation.contact, simulation.bumps) == (End.SUCCEEDED, True, 0)
    assert max(touch.speed for touch in simulation.touches) <= 0.045


def test_farther_away_the_error_names_blind_distance_and_the_place() -> None:
    outcome, simulation = dock(0.45, 1)
    assert outcome.error_code is ErrorCode.LOST_MARKER
    where = outcome.error_msg.split("the dock was seen last ")[1].split(" m before")[0]
    assert float(where) == pytest.approx(0.40, abs=0.04)
    assert "blind_distance (0.15 m) must be larger than that (4 times)" in outcome.error_msg
    assert not simulation.touches


def test_with_that_blind_distance_it_docks() -> None:
    outcome, simulation = dock(0.45, 1, blind_distance=0.5)
    assert (outcome.end, simulation.bumps) == (End.SUCCEEDED, 0)
