"""How docking does with each fault of a real robot: a table with one row a case and controller."""

import json
import math
import sys
from collections import Counter
from collections.abc import Sequence
from itertools import groupby
from multiprocessing import Pool
from pathlib import Path

from benchmarks.docking.cases import CASES
from benchmarks.docking.trial import Trial, keeps_limits, run_trial, settings_of
from docking.parameters import ControllerName

COLUMNS = (
    "docked",
    "without a retry",
    "median time",
    "retries",
    "bumps",
    "fastest contact",
    "worst lateral error",
    "too fast",
    "other results",
)
Job = tuple[str, ControllerName, int]


def measure(rows: str, seeds: range, processes: int, results: Path) -> str:
    """Run the cases whose names contain `rows`, and keep their figures.

    Figures of other rows stay as they were measured before, so that a table can be made in several runs.

    Args:
        rows: Part of the names of the cases, or several parts separated by commas; empty for all.
        seeds: One trial each.
        processes: How many trials run at a time.
        results: The file with the figures of all rows.

    Returns:
        The table.
    """
    parts = [part.strip() for part in rows.split(",")]
    chosen = [case for case in CASES if any(part in case.name for part in parts)]
    jobs = [(case.name, controller, seed) for case in chosen for controller in case.controllers for seed in seeds]
    figures: dict[str, dict[str, str]] = json.loads(results.read_text()) if results.exists() else {}
    results.parent.mkdir(parents=True, exist_ok=True)
    with Pool(processes) as pool:
        trials = zip(jobs, pool.imap(_run, jobs, chunksize=5), strict=True)
        for (name, controller), group in groupby(trials, key=lambda done: done[0][:2]):
            row = figures[f"{controller}: {name}"] = _figures(controller, [trial for _, trial in group])
            print(f"{controller}: {name}: {' | '.join(row.values())}", file=sys.stderr, flush=True)
            results.write_text(json.dumps(figures, indent=1, ensure_ascii=False) + "\n")
    return table(figures)


def table(figures: dict[str, dict[str, str]]) -> str:
    """All rows that have figures, as Markdown."""
    lines = [["controller", "fault", *COLUMNS]]
    for controller in ControllerName:
        for case in CASES:
            row = figures.get(f"{controller}: {case.name}")
            if row is not None:
                lines.append([f"`{controller}`", case.name, *row.values()])
    widths = [max(len(line[place]) for line in lines) for place in range(len(lines[0]))]
    lines.insert(1, ["-" * width for width in widths])
    return "\n".join("| " + " | ".join(map(str.ljust, line, widths)) + " |" for line in lines)


def _run(job: Job) -> Trial:
    name, controller, seed = job
    return run_trial(controller, seed, next(case for case in CASES if case.name == name))


def _figures(controller: ControllerName, trials: Sequence[Trial]) -> dict[str, str]:
    docked = [trial for trial in trials if trial.docked]
    limits = settings_of(controller).motion
    ends = Counter(_end(trial) for trial in trials if not trial.docked)
    seconds = sorted(trial.seconds for trial in docked)
    values = (
        _share(len(docked), len(trials)),
        _share(sum(trial.retries == 0 for trial in docked), len(trials)),
        f"{seconds[len(seconds) // 2]:.0f} s" if seconds else "-",
        str(sum(trial.retries for trial in trials)),
        str(sum(trial.bumps for trial in trials)),
        _fastest([speed for trial in trials for speed in trial.contacts]),
        f"{1000.0 * max(trial.aside for trial in docked):.0f} mm" if docked else "-",
        str(sum(not keeps_limits(trial, limits) for trial in trials)),
        ", ".join(f"{end} {count}" for end, count in ends.most_common()) or "none",
    )
    return dict(zip(COLUMNS, values, strict=True))


def _end(trial: Trial) -> str:
    return "docked after a bump" if trial.error_code == "NONE" else trial.error_code


def _fastest(speeds: Sequence[float]) -> str:
    return f"{max(speeds):.3f} m/s" if speeds else "-"


def _share(part: int, all_of: int) -> str:
    percent = 100.0 * part / all_of
    return f"{math.floor(10.0 * percent) / 10.0:g} %"
