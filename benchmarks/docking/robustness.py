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
from benchmarks.docking.table import markdown
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
    chosen = [case for case in CASES if is_chosen(case.name, rows)]
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


def is_chosen(name: str, rows: str) -> bool:
    """Whether a name contains one of some parts, which are separated by commas."""
    return any(part.strip() in name for part in rows.split(","))


def table(figures: dict[str, dict[str, str]]) -> str:
    """All rows that have figures, as Markdown."""
    lines = [["controller", "fault", *COLUMNS]]
    for controller in ControllerName:
        for case in CASES:
            row = figures.get(f"{controller}: {case.name}")
            if row is not None:
                lines.append([f"`{controller}`", case.name, *row.values()])
    return markdown(lines)


def _run(job: Job) -> Trial:
    name, controller, seed = job
    return run_trial(controller, seed, next(case for case in CASES if case.name == name))


def _figures(controller: ControllerName, trials: Sequence[Trial]) -> dict[str, str]:
    docked = [trial for trial in trials if trial.docked]
    limits = settings_of(controller).motion
    ends = Counter(end_of(trial) for trial in trials if not trial.docked)
    seconds = sorted(trial.seconds for trial in docked)
    values = (
        share(len(docked), len(trials)),
        share(sum(trial.retries == 0 for trial in docked), len(trials)),
        f"{seconds[len(seconds) // 2]:.0f} s" if seconds else "-",
        str(sum(trial.retries for trial in trials)),
        str(sum(trial.bumps for trial in trials)),
        fastest([speed for trial in trials for speed in trial.contacts]),
        f"{1000.0 * max(trial.aside for trial in docked):.0f} mm" if docked else "-",
        str(sum(not keeps_limits(trial, limits) for trial in trials)),
        ", ".join(f"{end} {count}" for end, count in ends.most_common()) or "none",
    )
    return dict(zip(COLUMNS, values, strict=True))


def end_of(trial: Trial) -> str:
    """How a trial ended that did not dock."""
    if trial.error_code != "NONE":
        return trial.error_code
    return "docked after a bump" if trial.bumps else "charged, then off the contacts"


def fastest(speeds: Sequence[float]) -> str:
    """The highest of these speeds."""
    return f"{max(speeds):.3f} m/s" if speeds else "-"


def share(part: int, all_of: int) -> str:
    """As a percentage that is never rounded up."""
    percent = 100.0 * part / all_of
    return f"{math.floor(10.0 * percent) / 10.0:g} %"
