"""The statistics of `make bench-docking`, from a few starts."""

import pytest
from benchmarks.docking.picture import picture
from benchmarks.docking.table import table
from benchmarks.docking.trial import REGIONS, Trial, keeps_limits, run_trial, settings_of

from docking.parameters import ControllerName

SEEDS = {ControllerName.DOCK_POSE: range(5000, 5010), ControllerName.INFRARED: range(5000, 5005)}


@pytest.fixture(scope="module")
def trials() -> dict[ControllerName, list[Trial]]:
    return {controller: [run_trial(controller, seed) for seed in SEEDS[controller]] for controller in REGIONS}


@pytest.mark.parametrize("controller", list(REGIONS))
def test_every_start_ends_on_the_dock(trials: dict[ControllerName, list[Trial]], controller: ControllerName) -> None:
    assert [trial for trial in trials[controller] if not trial.docked] == []


@pytest.mark.parametrize("controller", list(REGIONS))
def test_nothing_is_ever_too_fast(trials: dict[ControllerName, list[Trial]], controller: ControllerName) -> None:
    limits = settings_of(controller).motion
    assert [trial for trial in trials[controller] if not keeps_limits(trial, limits)] == []


def test_a_seed_gives_the_same_again(trials: dict[ControllerName, list[Trial]]) -> None:
    first = trials[ControllerName.DOCK_POSE][0]
    assert run_trial(ControllerName.DOCK_POSE, first.seed) == first


def test_the_table_and_the_picture_show_all_trials(trials: dict[ControllerName, list[Trial]]) -> None:
    text = table(trials, settings_of(ControllerName.DOCK_POSE).motion)
    assert "10 of 10 (100.0 %)" in text
    assert "5 of 5 (100.0 %)" in text
    drawn = picture(trials)
    assert drawn.startswith("<svg")
    assert drawn.count('<path d="M') >= 15
