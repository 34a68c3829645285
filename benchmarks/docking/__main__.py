"""Run the docking statistics: `make bench-docking`, or `python -m benchmarks.docking --help`."""

import argparse
import os
import sys
import time
from functools import partial
from importlib.util import find_spec
from multiprocessing import Pool
from pathlib import Path

from benchmarks.docking.comparison import COMPARISON
from benchmarks.docking.page import PAGE, RESULTS, SEEDS, STATISTICS, empty_part, with_list, with_part
from benchmarks.docking.picture import picture
from benchmarks.docking.robustness import ROBUSTNESS
from benchmarks.docking.rows import Table
from benchmarks.docking.table import table
from benchmarks.docking.trial import REGIONS, Trial, run_trial, settings_of
from docking.parameters import ControllerName


def run_trials(seeds: range, processes: int) -> dict[ControllerName, list[Trial]]:
    """One trial a seed for each controller, in the order of the seeds."""
    with Pool(processes) as pool:
        # The longest ones first, so that all cores are busy until the end.
        running = {
            controller: pool.map_async(partial(run_trial, controller), seeds, chunksize=10)
            for controller in reversed(REGIONS)
        }
        return {controller: running[controller].get() for controller in REGIONS}


def fault_table(options: argparse.Namespace) -> Table | None:
    """The table with a row for each fault that is asked for; None for the statistics."""
    if options.physics:
        from benchmarks.docking.physics import PHYSICS  # noqa: PLC0415 - only the benchmark's environment has MuJoCo

        return PHYSICS
    if options.robustness:
        return ROBUSTNESS
    return COMPARISON if options.laws else None


def parsed_options() -> argparse.Namespace:
    """What is asked for."""
    parser = argparse.ArgumentParser("benchmarks.docking", description="Dock from many random starts, in simulation")
    parser.add_argument("--trials", type=int, help="starts for each controller or row (default: as on the page)")
    parser.add_argument("--seed", type=int, help="of the first start (default: as on the page)")
    parser.add_argument("--processes", type=int, default=os.cpu_count() or 1, help="default: one a core")
    parser.add_argument("--output", type=Path, default=Path(__file__).parents[1] / "results", help="a folder")
    parser.add_argument("--docs", action="store_true", help="write into the repository's pages instead")
    tables = parser.add_mutually_exclusive_group()
    tables.add_argument("--robustness", action="store_true", help="with each fault of a real robot instead")
    tables.add_argument("--laws", action="store_true", help="with each fault, beside nav2's control law")
    tables.add_argument("--physics", action="store_true", help="in MuJoCo, beside nav2's law: by make bench-physics")
    parser.add_argument(
        "--rows", default="", help="of these tables: only those whose names contain one of these, comma-separated"
    )
    parser.add_argument("--missing", action="store_true", help="of these tables: only rows that are not there yet")
    options = parser.parse_args()
    if options.physics and find_spec("mujoco") is None:
        parser.error("--physics needs MuJoCo, which make bench-physics installs")
    if options.docs and (options.trials is not None or options.seed is not None):
        parser.error("--docs takes the trials and the seed that the page says")
    return options


def page_of(options: argparse.Namespace, name: str) -> Path:
    """The file that a table is written into."""
    if options.docs:
        return PAGE if name == STATISTICS else RESULTS
    page: Path = options.output / f"docking-{name}.md"
    page.parent.mkdir(parents=True, exist_ok=True)
    if not page.exists():
        page.write_text(empty_part(name))
    return page


def main() -> None:
    """Run the trials, print the table, write the table and the picture."""
    options = parsed_options()
    begun = time.monotonic()
    faults = fault_table(options)
    name = STATISTICS if faults is None else faults.name
    page, usual = page_of(options, name), SEEDS[name]
    first = usual.start if options.seed is None else options.seed
    seeds = range(first, first + (options.trials or len(usual)))
    if faults is None:
        trials = run_trials(seeds, options.processes)
        text = table(trials, settings_of(ControllerName.DOCK_POSE).motion)
        page.write_text(with_part(page.read_text(), name, text))
        drawing = (
            page.parent / "images" / "docking-trails.svg" if options.docs else page.with_name("docking-trails.svg")
        )
        drawing.write_text(picture(trials))
    else:
        text = faults.measure(options.rows, seeds, options.processes, page, missing=options.missing)
    if options.docs:
        PAGE.write_text(with_list(PAGE.read_text(), RESULTS.read_text()))
    print(text)
    print(f"\n{time.monotonic() - begun:.0f} s; written: {page}", file=sys.stderr)


if __name__ == "__main__":
    main()
