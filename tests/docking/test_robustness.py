"""The robustness table of `make bench-docking`: its cases, and how it is made."""

from pathlib import Path
from random import Random

from benchmarks.docking.cases import CASES
from benchmarks.docking.robustness import COLUMNS, measure
from benchmarks.docking.trial import simulation_of

from docking.simulation.settings import Settings


def test_each_case_has_its_name_and_changes_something() -> None:
    names = [case.name for case in CASES]
    assert len(set(names)) == len(names)
    for case in CASES[1:]:
        changed = case.change(Settings(), Random(1)) != Settings()
        elsewhere = case.region is not None
        assert changed or elsewhere or case.jitter > 0.0 or case.disturb is not CASES[0].disturb, case.name


def test_a_case_is_the_same_again_for_a_seed() -> None:
    case = next(case for case in CASES if case.name == "one wheel 10 % off")
    changed = {simulation_of(case.controllers[0], seed, case).settings.robot for seed in range(20)}
    assert len(changed) == 4, "either wheel, larger or smaller"
    once, again = (simulation_of(case.controllers[0], 7, case).settings for _ in range(2))
    assert once == again


def test_rows_are_measured_one_after_another_into_one_table(tmp_path: Path) -> None:
    results = tmp_path / "some" / "figures.json"
    measure("without velocity", range(1), 1, results)
    text = measure("both wheels 8 % larger", range(2), 1, results)
    lines = text.splitlines()
    assert lines[0].count("|") == len(COLUMNS) + 3
    assert [line.split("|")[2].strip() for line in lines[2:]] == [
        "both wheels 8 % larger",
        "odometry without velocity",
    ] * 2
