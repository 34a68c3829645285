"""What a long run has measured: printed, and added as JSON to the file that `CHAOS_REPORT` names.

`python -m tests.chaos.report FIGURES DOCUMENT` puts that file into a document, as Markdown, after its last heading.
"""

import json
import os
import sys
from datetime import UTC, datetime
from itertools import groupby
from pathlib import Path
from typing import Any

HEADING = "## The last long run"


def report(title: str, figures: dict[str, Any]) -> None:
    """Say what one test has measured."""
    print(f"{title}: {figures}")
    if path := os.environ.get("CHAOS_REPORT"):
        with Path(path).open("a") as file:
            file.write(json.dumps([title, figures]) + "\n")


def rendered(reports: list[tuple[str, dict[str, Any]]]) -> str:
    """Tests that measured the same are rows of one table; another one has a table of its own."""
    parts = []
    for names, group in groupby(reports, key=lambda entry: tuple(entry[1])):
        tests = list(group)
        if len(tests) > 1:
            rows = [("", *names), ("---",) * (len(names) + 1)]
            rows += [(title, *map(str, figures.values())) for title, figures in tests]
        else:
            ((title, figures),) = tests
            parts.append(f"### {title}\n")
            rows = [("", ""), ("---", "---"), *((name, str(value)) for name, value in figures.items())]
        cells = ([cell.replace("|", "\\|") for cell in row] for row in rows)
        parts.append("\n".join(f"| {' | '.join(row)} |" for row in cells) + "\n")
    return "\n".join(parts)


def main(figures: Path, document: Path) -> None:
    """Put the figures in place of those of the run before."""
    text = document.read_text().partition(HEADING)[0]
    now = f"{datetime.now(UTC):%Y-%m-%d}, {os.cpu_count()} cores."
    reports = [tuple(json.loads(line)) for line in figures.read_text().splitlines()]
    document.write_text(f"{text}{HEADING}\n\n{now}\n\n{rendered(reports)}")


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
