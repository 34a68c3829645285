"""Our way onto the dock beside nav2's graceful law, with the same starts and faults: a table with two rows a fault."""

import json
import math
import sys
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import groupby
from multiprocessing import Pool
from pathlib import Path

from benchmarks.docking.cases import CASES, DOCK_POSE
from benchmarks.docking.graceful import GracefulLaw
from benchmarks.docking.robustness import fastest, share
from benchmarks.docking.table import markdown, spread
from benchmarks.docking.trial import Trial, run_trial

LAWS: Mapping[str, GracefulLaw | None] = {"ours": None, "nav2's law": GracefulLaw()}
FAULTS = {
    case.name: case
    for case in CASES
    if DOCK_POSE in case.controllers and case.region is None and not case.known and not case.search_radius
}
"""What makes a difference after the staging pose, by name."""
Job = tuple[str, str, int]
"""A row, a law and a seed."""


def run_job(job: Job) -> Trial:
    """One trial with a fault."""
    name, law, seed = job
    return run_trial(DOCK_POSE, seed, FAULTS[name], LAWS[law])


def measure(run: Callable[[Job], Trial], rows: Iterable[str], seeds: range, processes: int, results: Path) -> str:
    """Run all trials of some rows, and keep their figures beside those of other rows.

    Args:
        run: Runs one trial.
        rows: Their names.
        seeds: One trial each, with each law.
        processes: How many trials run at a time.
        results: The file with the figures of all rows.

    Returns:
        The table.
    """
    jobs = [(row, law, seed) for row in rows for law in LAWS for seed in seeds]
    figures: dict[str, dict[str, str]] = json.loads(results.read_text()) if results.exists() else {}
    results.parent.mkdir(parents=True, exist_ok=True)
    with Pool(processes) as pool:
        trials = zip(jobs, pool.imap(run, jobs, chunksize=5), strict=True)
        for (name, law), group in groupby(trials, key=lambda done: done[0][:2]):
            row = figures[f"{name}: {law}"] = {"case": name, "law": law} | figures_of([trial for _, trial in group])
            print(" | ".join(row.values()), file=sys.stderr, flush=True)
            results.write_text(json.dumps(figures, indent=1, ensure_ascii=False) + "\n")
    return markdown([list(next(iter(figures.values()))), *(list(row.values()) for row in figures.values())])


def figures_of(trials: Sequence[Trial]) -> dict[str, str]:
    """By column; times and errors are those of the robots that docked: median, 95th percentile and greatest.

    A goal that succeeded is not clean after a bump, or with the robot off the contacts a second later.
    """
    docked = [trial for trial in trials if trial.docked]
    ends = Counter(
        "not clean" if trial.error_code == "NONE" else trial.error_code for trial in trials if not trial.docked
    )
    return {
        "docked": share(len(docked), len(trials)),
        "without a retry": share(sum(trial.retries == 0 for trial in docked), len(trials)),
        "time": spread([trial.seconds for trial in docked], "s", 1.0, 0),
        "lateral error": spread([trial.aside for trial in docked], "mm", 1000.0, 1),
        "heading error": spread([math.degrees(trial.askew) for trial in docked], "°", 1.0, 1),
        "bumps": str(sum(trial.bumps for trial in trials)),
        "fastest contact": fastest([speed for trial in trials for speed in trial.contacts]),
        "other results": ", ".join(f"{end} {count}" for end, count in ends.most_common()) or "none",
    }
