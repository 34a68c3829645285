"""How docking does with each fault of a real robot: a table with one row a case and controller."""

from collections import Counter
from collections.abc import Sequence

from benchmarks.docking.cases import CASES, CASES_BY_NAME
from benchmarks.docking.page import Row
from benchmarks.docking.rows import Job, Key, Table, fastest, share
from benchmarks.docking.trial import Trial, keeps_limits, run_trial, settings_of
from docking.parameters import ControllerName


def _run(job: Job) -> Trial:
    (controller, name), seed = job
    return run_trial(_controller(controller), seed, CASES_BY_NAME[name])


def _controller(cell: str) -> ControllerName:
    return ControllerName(cell.strip("`"))


def _figures(key: Key, trials: Sequence[Trial]) -> Row:
    docked = [trial for trial in trials if trial.docked]
    limits = settings_of(_controller(key[0])).motion
    ends = Counter(end_of(trial) for trial in trials if not trial.docked)
    seconds = sorted(trial.seconds for trial in docked)
    return {
        "docked": share(len(docked), len(trials)),
        "without a retry": share(sum(trial.retries == 0 for trial in docked), len(trials)),
        "median time": f"{seconds[len(seconds) // 2]:.0f} s" if seconds else "-",
        "retries": str(sum(trial.retries for trial in trials)),
        "bumps": str(sum(trial.bumps for trial in trials)),
        "fastest contact": fastest([speed for trial in trials for speed in trial.contacts]),
        "worst lateral error": f"{1000.0 * max(trial.aside for trial in docked):.0f} mm" if docked else "-",
        "too fast": str(sum(not keeps_limits(trial, limits) for trial in trials)),
        "other results": ", ".join([*(f"{end} {count}" for end, count in ends.most_common()), *_hits(trials)])
        or "none",
    }


def _hits(trials: Sequence[Trial]) -> tuple[str, ...]:
    """How fast the robots ran into something that is not the dock, the first time and later, where any did."""
    first = [trial.hits[0] for trial in trials if trial.hits]
    later = [speed for trial in trials for speed in trial.hits[1:]]
    return (f"first hit {fastest(first)}, {len(later)} later ones {fastest(later)}",) if first else ()


def end_of(trial: Trial) -> str:
    """How a trial ended that did not dock."""
    if trial.error_code != "NONE":
        return trial.error_code
    return "docked after a bump" if trial.bumps else "charged, then off the contacts"


ROBUSTNESS = Table(
    "robustness",
    ("controller", "fault"),
    tuple(
        (f"`{controller}`", case.name)
        for controller in ControllerName
        for case in CASES
        if controller in case.controllers
    ),
    _run,
    _figures,
)
