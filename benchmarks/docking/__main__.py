"""Run the docking statistics: `make bench-docking`, or `python -m benchmarks.docking --help`."""

import argparse
import os
import sys
import time
from functools import partial
from multiprocessing import Pool
from pathlib import Path

from benchmarks.docking import comparison, robustness
from benchmarks.docking.picture import picture
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


def main() -> None:
    """Run the trials, print the table, write the table and the picture."""
    parser = argparse.ArgumentParser("benchmarks.docking", description="Dock from many random starts, in simulation")
    parser.add_argument("--trials", type=int, help="starts for each controller (default: 1000, 200 for each fault)")
    parser.add_argument("--seed", type=int, default=0, help="of the first start (default: 0)")
    parser.add_argument("--processes", type=int, default=os.cpu_count() or 1, help="default: one a core")
    parser.add_argument("--output", type=Path, default=Path(__file__).parents[1] / "results", help="a folder")
    parser.add_argument("--robustness", action="store_true", help="with each fault of a real robot instead")
    parser.add_argument("--laws", action="store_true", help="with each fault, by our controller and by nav2's law")
    parser.add_argument(
        "--rows",
        default="",
        help="with a table of faults: only those whose names contain one of these, comma-separated",
    )
    options = parser.parse_args()
    begun = time.monotonic()
    count = options.trials or (200 if options.robustness or options.laws else 1000)
    seeds = range(options.seed, options.seed + count)
    if options.robustness or options.laws:
        name = "docking-laws" if options.laws else "docking-robustness"
        figures = options.output / f"{name}.json"
        if options.laws:
            rows = [row for row in comparison.FAULTS if robustness.is_chosen(row, options.rows)]
            text = comparison.measure(comparison.run_job, rows, seeds, options.processes, figures)
        else:
            text = robustness.measure(options.rows, seeds, options.processes, figures)
        print(text)
        (options.output / f"{name}.md").write_text(text + "\n")
        print(f"\n{time.monotonic() - begun:.0f} s; written: {name}.md in {options.output}", file=sys.stderr)
        return
    trials = run_trials(seeds, options.processes)
    seconds = time.monotonic() - begun
    text = table(trials, settings_of(ControllerName.DOCK_POSE).motion)
    print(text)
    options.output.mkdir(parents=True, exist_ok=True)
    (options.output / "docking.md").write_text(text + "\n")
    (options.output / "docking-trails.svg").write_text(picture(trials))
    simulated = sum(trial.seconds for some in trials.values() for trial in some)
    print(
        f"\n{seconds:.0f} s for {simulated / 3600:.1f} simulated hours; written: docking.md and docking-trails.svg in"
        f" {options.output}",
        file=sys.stderr,
    )


if __name__ == "__main__":
    main()
