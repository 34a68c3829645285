"""The figures as a Markdown table."""

from benchmarks.figures import BARE, OURS, Figure, Results


def table(results: Results) -> str:
    """One line a measure, one column a system, and ours by the bare client's and by each variant's."""
    systems = results.systems()
    bases = [system for system in systems if system == BARE or system.startswith(f"{OURS} ")]
    bases = bases if OURS in systems else []
    lines = [["case", "measure", *systems, *(f"÷ {base}" for base in bases)]]
    for case, measure in results.rows():
        found = [results.find(case, measure, system) for system in systems]
        ratios = [results.ratio(case, measure, OURS, base) for base in bases]
        lines.append([case, measure, *map(_cell, found), *("" if r is None else f"{r:.2f}" for r in ratios)])
    widths = [max(len(line[column]) for line in lines) for column in range(len(lines[0]))]
    lines.insert(1, ["-" * width for width in widths])
    text = "\n".join("| " + " | ".join(map(str.ljust, line, widths)) + " |" for line in lines)
    notes = dict.fromkeys(f"{f.system}, {f.case or 'all cases'}: {f.note}" for f in results.figures if f.note)
    return "\n".join([text, "", *(f"- {note}" for note in notes)])


def _cell(figure: Figure | None) -> str:
    if figure is None or figure.value is None:
        return "-"
    value = f"{figure.value:.0f}" if figure.value >= 100 or figure.unit in ("lost", "Hz") else f"{figure.value:.2f}"
    return f"{value} {figure.unit}".strip()
