"""Docking with a camera that is not mounted where tf has it."""

from dataclasses import replace

import pytest

from docking.core.errors import ErrorCode
from docking.core.geometry import Pose
from docking.goal.dock_memory import DockMemory
from docking.goal.outcome import End, Outcome
from docking.nodes.dock_server import DockAction
from docking.parameters import ControllerName, Dock, DockSettings, RecoverySettings
from docking.simulation.faults import Fault
from docking.simulation.marker import MarkerSettings
from docking.simulation.settings import Settings
from docking.simulation.simulation import Simulation

DOCKING = DockSettings(controller=ControllerName.DOCK_POSE, recovery=RecoverySettings(max_corrections=0))


def dock(
    aside: float,
    seed: int = 1,
    *,
    dead: bool = False,
    memory: DockMemory | None = None,
    settings: DockSettings = DOCKING,
) -> tuple[Outcome, Simulation]:
    """One goal, with a camera that is to the left by some metres."""
    marker = MarkerSettings(camera_error_y=aside)
    simulation = Simulation(Settings(start=Pose(-1.3, 0.2, -0.1), marker=marker), seed)
    simulation.set_fault(Fault.DEAD_CHARGER, dead)
    goal = DockAction().make_goal(settings, memory or DockMemory(), 0.0)
    while not isinstance(step := goal.step(simulation.observe()), Outcome):
        simulation.run(DOCKING.control_period, step.velocity)
    return step, simulation


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("aside", [0.03, -0.03])
def test_after_one_miss_it_knows_how_far_and_which_side_and_what_to_correct(aside: float, seed: int) -> None:
    outcome, simulation = dock(aside, seed)
    assert (outcome.end, outcome.retries, simulation.bumps) == (End.SUCCEEDED, 1, 1)
    (doubt,) = [one for one in outcome.doubts if "the camera seems to be" in one]
    millimetres = int(doubt.split("seems to be ")[1].split(" mm")[0])
    assert millimetres == pytest.approx(30.0, abs=12.0)
    assert f"mm {'to the left' if aside > 0.0 else 'to the right'} of where tf has it" in doubt
    assert "mounting pose in tf" in doubt
    assert "call calibrate_dock" in doubt
    assert max(touch.speed for touch in simulation.touches) <= 0.045


def test_farther_than_5_cm_it_does_not_try_again_by_itself() -> None:
    outcome, simulation = dock(0.08, seed=2)
    assert (outcome.end, outcome.error_code, simulation.bumps) == (End.ABORTED, ErrorCode.FAILED_TO_CHARGE, 1)
    assert "mm to the left of where tf has it: correct the camera's mounting pose in tf" in outcome.error_msg


def test_a_camera_in_its_place_is_not_blamed_for_a_dead_charger() -> None:
    outcome, simulation = dock(0.0, dead=True)
    assert outcome.error_code is ErrorCode.FAILED_TO_CHARGE
    assert "the camera seems" not in outcome.error_msg
    assert "external_detection_translation_y" in outcome.error_msg
    assert simulation.bumps == 0


@pytest.mark.parametrize("seed", [1, 2, 3, 4])
@pytest.mark.parametrize("aside", [0.03, -0.03])
def test_the_next_goal_does_not_miss_and_says_again_what_to_correct(aside: float, seed: int) -> None:
    memory = DockMemory()
    first, before = dock(aside, seed, memory=memory)
    assert (first.end, before.bumps) == (End.SUCCEEDED, 1)
    for goal in range(2):
        outcome, simulation = dock(aside, seed + 10 + goal, memory=memory)
        assert (outcome.end, outcome.retries, simulation.bumps) == (End.SUCCEEDED, 0, 0)
        side = "to the left" if aside > 0.0 else "to the right"
        assert any(f"mm {side} of where tf has it" in doubt for doubt in outcome.doubts)
        assert max(touch.speed for touch in simulation.touches) <= 0.045


@pytest.mark.parametrize("seed", [1, 2, 3, 4])
def test_a_camera_that_is_corrected_in_tf_is_found_out_after_one_miss(seed: int) -> None:
    memory = DockMemory()
    dock(0.03, seed, memory=memory)
    outcome, simulation = dock(0.0, seed, memory=memory)
    assert (outcome.end, outcome.retries) == (End.SUCCEEDED, 1)
    assert max(touch.speed for touch in simulation.touches) <= 0.045
    outcome, simulation = dock(0.0, seed + 10, memory=memory)
    assert (outcome.end, outcome.retries, simulation.bumps) == (End.SUCCEEDED, 0, 0)
    assert not any("camera" in doubt for doubt in outcome.doubts)


def test_a_camera_that_is_corrected_in_the_parameters_is_where_these_have_it() -> None:
    memory = DockMemory()
    dock(0.03, memory=memory)
    calibrated = replace(DOCKING, dock=Dock(external_detection_translation_y=0.03))
    outcome, simulation = dock(0.03, memory=memory, settings=calibrated)
    assert (outcome.end, outcome.retries, simulation.bumps) == (End.SUCCEEDED, 0, 0)
