"""Run the docking statistics: `make bench-docking`, or `python -m benchmarks.docking --help`."""

import argparse
import os
import sys
import time
from functools import partial
from importlib.util import find_spec
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


def faults_table(options: argparse.Namespace, seeds: range) -> tuple[str, str]:
    """Run the trials of a table with a row for each fault; return the name of its file and the table."""
    if options.robustness:
        name = "docking-robustness"
        return name, robustness.measure(options.rows, seeds, options.processes, options.output / f"{name}.json")
    if options.physics:
        from benchmarks.docking import physics  # noqa: PLC0415 - only the benchmark's environment has MuJoCo

        name, run, rows = "docking-physics", physics.run_job, list(physics.WORLDS)
    else:
        name, run, rows = "docking-laws", comparison.run_job, list(comparison.FAULTS)
    chosen = [row for row in rows if robustness.is_chosen(row, options.rows)]
    figures = options.output / f"{name}.json"
    return name, comparison.measure(run, chosen, seeds, options.processes, figures)


def parsed_options() -> argparse.Namespace:
    """What is asked for."""
    parser = argparse.ArgumentParser("benchmarks.docking", description="Dock from many random starts, in simulation")
    parser.add_argument(
        "--trials", type=int, help="starts for each controller (default: 1000; 200 for each row of the other tables)"
    )
    parser.add_argument("--seed", type=int, default=0, help="of the first start (default: 0)")
    parser.add_argument("--processes", type=int, default=os.cpu_count() or 1, help="default: one a core")
    parser.add_argument("--output", type=Path, default=Path(__file__).parents[1] / "results", help="a folder")
    tables = parser.add_mutually_exclusive_group()
    tables.add_argument("--robustness", action="store_true", help="with each fault of a real robot instead")
    tables.add_argument("--laws", action="store_true", help="with each fault, beside nav2's control law")
    tables.add_argument("--physics", action="store_true", help="in MuJoCo, beside nav2's law: by make bench-physics")
    parser.add_argument(
        "--rows", default="", help="of these tables: only those whose names contain one of these, comma-separated"
    )
    options = parser.parse_args()
    if options.physics and find_spec("mujoco") is None:
        parser.error("--physics needs MuJoCo, which make bench-physics installs")
    return options


def main() -> None:
    """Run the trials, print the table, write the table and the picture."""
    options = parsed_options()
    begun = time.monotonic()
    is_short = options.robustness or options.laws or options.physics
    count = options.trials or (200 if is_short else 1000)
    seeds = range(options.seed, options.seed + count)
    if is_short:
        name, text = faults_table(options, seeds)
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
