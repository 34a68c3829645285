"""The robustness table of `make bench-docking`: its cases, and how it is made."""

from collections.abc import Sequence
from pathlib import Path
from random import Random

import pytest
from benchmarks.docking.cases import CASES
from benchmarks.docking.comparison import COMPARISON, with_laws
from benchmarks.docking.page import (
    PAGE,
    RESULTS,
    SEEDS,
    STATISTICS,
    empty_part,
    is_low,
    part_of,
    rows_in,
    table_of,
    with_list,
    with_part,
)
from benchmarks.docking.robustness import ROBUSTNESS
from benchmarks.docking.trial import simulation_of
from benchmarks.docking.worlds import WORLDS

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
    page = tmp_path / "page.md"
    page.write_text(f"Before.\n{empty_part(ROBUSTNESS.name)}After.\n")
    ROBUSTNESS.measure("without velocity", range(1), 1, page)
    text = ROBUSTNESS.measure("both wheels 8 % larger", range(2), 1, page)
    assert [key for key in rows_in(text) if key[0] == "`infrared`"] == [
        ("`infrared`", "both wheels 8 % larger"),
        ("`infrared`", "odometry without velocity"),
    ]
    assert len(rows_in(text)) == 4
    assert page.read_text().startswith("Before.\n<!--")
    assert page.read_text().endswith("-->\nAfter.\n")
    assert part_of(page.read_text(), ROBUSTNESS.name) == text
    assert ROBUSTNESS.measure("without velocity", range(9), 1, page, missing=True) == text, "it is there"


def test_a_column_that_only_some_rows_have_is_empty_in_the_others() -> None:
    old, new = {"docked": "100 %", "bumps": "0"}, {"docked": "100 %", "hits": "1", "bumps": "0"}
    text = table_of({("a", "one"): old, ("a", "two"): new}, ("controller", "fault"), [("a", "one"), ("a", "two")])
    assert rows_in(text) == {("a", "one"): {**new, "hits": ""}, ("a", "two"): new}


PHYSICS = (("physics", with_laws({name: case for name, (_, case) in WORLDS.items()})),)
TABLES = [*((table.name, table.keys) for table in (ROBUSTNESS, COMPARISON)), *PHYSICS]


@pytest.mark.parametrize(("name", "keys"), TABLES)
def test_the_results_have_a_row_for_each_case(name: str, keys: Sequence[tuple[str, str]]) -> None:
    shown = rows_in(part_of(RESULTS.read_text(), name))
    assert list(keys) == list(shown), f"make bench-docking BENCH_ARGS='--{name} --docs --missing'"


@pytest.mark.parametrize("name", SEEDS)
def test_the_page_says_with_which_starts_its_tables_are_made(name: str) -> None:
    page = PAGE if name == STATISTICS else RESULTS
    before = page.read_text().partition(f"<!-- {name}:")[0].rpartition("<!-- end")[2]
    seeds = SEEDS[name]
    assert f"{len(seeds)} starts for each" in before
    assert f"seeds {seeds.start} to {seeds.stop - 1}" in before


def test_the_page_names_every_row_that_docks_less_than_95_percent_with_the_reason() -> None:
    page, results = PAGE.read_text(), RESULTS.read_text()
    assert with_list(page, results) == page, "make bench-docking BENCH_ARGS='--docs'"
    low = [name for (_, name), row in rows_in(part_of(results, "robustness")).items() if is_low(row)]
    reasons = {case.name: case.why for case in CASES}
    assert [name for name in low if not reasons[name]] == []
    assert part_of(page, "below").count("* (") >= len(low)


def test_a_row_that_falls_below_95_percent_is_named() -> None:
    row = f"| controller | fault | docked |\n| - | - | - |\n| `dock_pose` | {CASES[0].name} | 94.9 % |"
    page = with_list(empty_part("below"), with_part(empty_part("robustness"), "robustness", row))
    assert part_of(page, "below") == f"- *{CASES[0].name}* (`dock_pose`, 94.9 %)."
