"""The latencies as a picture."""

from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")

from matplotlib import pyplot as plt

from benchmarks.figures import Results


def plot(results: Results, *files: Path) -> None:
    """Medians as bars with the 99th percentile as a whisker, each the median of the turns; one group a case."""
    rows = [(case, measure) for case, measure in results.rows() if measure.endswith("p50")]
    systems = [s for s in results.systems() if any(_value(results, case, m, s) for case, m in rows)]
    if not rows or not systems:
        return
    figure, axes = plt.subplots(figsize=(11, 1.2 + 0.3 * len(rows) * len(systems)), layout="constrained")
    height = 0.8 / len(systems)
    for index, system in enumerate(systems):
        medians = [_value(results, case, measure, system) for case, measure in rows]
        p99 = [_value(results, case, measure.replace("p50", "p99"), system) for case, measure in rows]
        places = [row + index * height for row in range(len(rows))]
        whiskers = [max(0.0, high - low) for low, high in zip(medians, p99, strict=True)]
        axes.barh(places, medians, height, label=system, xerr=[[0.0] * len(rows), whiskers], error_kw={"lw": 0.8})
    axes.set_yticks([row + 0.4 - height / 2 for row in range(len(rows))], [f"{c}\n{m}" for c, m in rows], fontsize=8)
    axes.invert_yaxis()
    axes.set_xscale("log")
    axes.set_xlabel("ms (bar: median, whisker: 99th percentile)")
    axes.legend()
    axes.grid(axis="x", which="both", alpha=0.3)
    for file in files:
        figure.savefig(file, dpi=120)


def _value(results: Results, case: str, measure: str, system: str) -> float:
    found = results.find(case, measure, system)
    return found.value if found else 0.0
