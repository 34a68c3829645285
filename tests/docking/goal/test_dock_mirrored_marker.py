"""Docking by a flat marker whose heading is mirrored at the line of sight half of the time."""

import pytest
from benchmarks.docking.cases import CASES
from benchmarks.docking.trial import run_trial

from docking.parameters import ControllerName

CASE = next(case for case in CASES if case.name == "two-fold ambiguity of a flat marker")


@pytest.mark.parametrize("seed", [1001, 1003, 1006, 1008, 1009])
def test_it_docks_without_a_bump(seed: int) -> None:
    trial = run_trial(ControllerName.DOCK_POSE, seed, CASE)
    assert (trial.docked, trial.bumps) == (True, 0)
    assert max(trial.contacts) <= 0.045
