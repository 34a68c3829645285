"""Our way onto the dock beside nav2's graceful law, with the same starts and faults: a table with two rows a fault."""

import math
from collections import Counter
from collections.abc import Mapping, Sequence

from benchmarks.docking.cases import CASES, DOCK_POSE, Case
from benchmarks.docking.graceful import GracefulLaw
from benchmarks.docking.page import Row
from benchmarks.docking.rows import Job, Key, Table, fastest, share
from benchmarks.docking.table import spread
from benchmarks.docking.trial import Trial, run_trial

OURS = "ours"
LAWS: Mapping[str, GracefulLaw | None] = {OURS: None, "nav2's law": GracefulLaw()}
FAULTS = {
    case.name: case
    for case in CASES
    if DOCK_POSE in case.controllers and case.region is None and not (case.known or case.search_radius or case.recovers)
}
"""What makes a difference after the staging pose, by name."""


def _run(job: Job) -> Trial:
    (name, law), seed = job
    return run_trial(DOCK_POSE, seed, FAULTS[name], LAWS[law])


def figures_of(_key: Key, trials: Sequence[Trial]) -> Row:
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


def with_laws(cases: Mapping[str, Case]) -> tuple[Key, ...]:
    """Two rows for each case, one for each law; nav2's law needs a marker."""
    return tuple((name, law) for name, case in cases.items() for law in LAWS if law == OURS or not case.located)


COMPARISON = Table("laws", ("case", "law"), with_laws(FAULTS), _run, figures_of)
