"""The figures as a Markdown table, and beneath it what was left out."""

from benchmarks.figures import BARE, OURS, ROSBRIDGE, ROSBRIDGE_SUITE, STOCK, Figure, Results


def table(results: Results) -> str:
    """One line a measure, one column a system, and ours by each that it is compared with."""
    systems = results.systems()
    compared = (BARE, STOCK, ROSBRIDGE, ROSBRIDGE_SUITE)
    bases = [system for system in systems if system in compared or system.startswith(f"{OURS} ")]
    bases = bases if OURS in systems else []
    lines = [["case", "measure", *systems, *(f"÷ {base}" for base in bases)]]
    for case, measure in results.rows():
        found = [results.find(case, measure, system) for system in systems]
        ratios = [results.ratio(case, measure, OURS, base) for base in bases]
        lines.append([case, measure, *map(_cell, found), *("" if r is None else f"{r:.2f}" for r in ratios)])
    widths = [max(len(line[column]) for line in lines) for column in range(len(lines[0]))]
    lines.insert(1, ["-" * width for width in widths])
    text = "\n".join("| " + " | ".join(map(str.ljust, line, widths)) + " |" for line in lines)
    return "\n".join([text, "", *_left_out(results)])


def _cell(figure: Figure | None) -> str:
    """The median, and the range of the turns where they differ."""
    if figure is None:
        return "-"
    value, low, high = (_number(number, figure.unit) for number in (figure.value, *figure.spread))
    return f"{value} {figure.unit}" if low == high else f"{value} {figure.unit} ({low} to {high})"


def _number(value: float, unit: str) -> str:
    return f"{value:.0f}" if value >= 100 or unit in ("lost", "Hz") else f"{value:.2f}"


def _left_out(results: Results) -> list[str]:
    """One line a system and case, with the number of turns where other turns gave figures."""
    lines = []
    for (system, case), reasons in results.left_out.items():
        good = max((len(f.turns) for f in results.figures.values() if (f.case, f.system) == (case, system)), default=0)
        turns = f" ({len(reasons)} of {good + len(reasons)} turns)" if good else ""
        lines.append(f"- left out: {system}{f', {case}' if case else ''}{turns}: {'; '.join(dict.fromkeys(reasons))}")
    return lines
