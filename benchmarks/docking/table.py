"""The figures of all trials as a Markdown table."""

import math
from collections import Counter
from collections.abc import Mapping, Sequence

from benchmarks.docking.trial import Trial
from docking.parameters import MotionLimits


def table(trials: Mapping[str, Sequence[Trial]], limits: MotionLimits) -> str:
    """One line a measure, one column a controller."""
    lines = [["", *(f"`{name}`" for name in trials)]]
    columns = [_column(some, limits) for some in trials.values()]
    lines += [[measure, *(column[measure] for column in columns)] for measure in columns[0]]
    return markdown(lines)


def markdown(lines: Sequence[Sequence[str]]) -> str:
    """A table of these lines, the first of which are the headings."""
    widths = [max(len(line[place]) for line in lines) for place in range(len(lines[0]))]
    lines = [lines[0], ["-" * width for width in widths], *lines[1:]]
    return "\n".join("| " + " | ".join(map(str.ljust, line, widths)) + " |" for line in lines)


def _column(trials: Sequence[Trial], limits: MotionLimits) -> dict[str, str]:
    docked = [trial for trial in trials if trial.docked]
    retries = Counter(trial.retries for trial in trials)
    ends = Counter(trial.error_code for trial in trials if not trial.docked)
    return {
        "docked within 2 cm and 5°": f"{len(docked)} of {len(trials)} ({100 * len(docked) / len(trials):.1f} %)",
        "time, median / 95 % / longest": spread([trial.seconds for trial in docked], "s", 1.0, 0),
        "docked after 0 / 1 / 2 / 3 retries": " / ".join(str(retries[number]) for number in range(4)),
        "final lateral error, median / 95 % / greatest": spread([trial.aside for trial in docked], "mm", 1000.0, 1),
        "final heading error, median / 95 % / greatest": spread(
            [math.degrees(trial.askew) for trial in docked], "°", 1.0, 1
        ),
        "hit the dock elsewhere": str(sum(trial.bumps > 0 for trial in trials)),
        "highest speed (limit)": (
            f"{_most(trials, 'v_linear'):.2f} m/s ({limits.v_linear_max:g}),"
            f" {_most(trials, 'v_angular'):.2f} rad/s ({limits.v_angular_max:g})"
        ),
        "highest acceleration (limit)": (
            f"{_most(trials, 'a_linear'):.2f} m/s² ({limits.a_linear_max:g}),"
            f" {_most(trials, 'a_angular'):.2f} rad/s² ({limits.a_angular_max:g})"
        ),
        "other results": ", ".join(f"{code} {count}" for code, count in ends.items()) or "none",
    }


def _most(trials: Sequence[Trial], name: str) -> float:
    return max(getattr(trial, name) for trial in trials)


def spread(values: Sequence[float], unit: str, scale: float, digits: int) -> str:
    """Median, 95th percentile and greatest."""
    if not values:
        return "-"
    ordered = sorted(scale * value for value in values)
    chosen = (ordered[len(ordered) // 2], ordered[int(0.95 * len(ordered))], ordered[-1])
    return " / ".join(f"{value:.{digits}f}" for value in chosen) + f" {unit}"
