"""What a long run has measured: printed, and added to the file that `CHAOS_REPORT` names, as Markdown.

`python -m tests.chaos.report FIGURES DOCUMENT` puts that file into a document, after its last heading.
"""

import os
import sys
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

HEADING = "## The last long run"


def report(title: str, figures: dict[str, Any]) -> None:
    """Tell the figures of one test."""
    rows = [f"| {name} | {value} |" for name, value in figures.items()]
    table = "\n".join([f"### {title}", "", "| | |", "|---|---|", *rows, "", ""])
    print(table)
    if path := os.environ.get("CHAOS_REPORT"):
        with Path(path).open("a") as file:
            file.write(table)


def main(figures: Path, document: Path) -> None:
    """Put the figures in place of those of the run before."""
    text = document.read_text().partition(HEADING)[0]
    now = f"{datetime.now(UTC):%Y-%m-%d}, {os.cpu_count()} cores."
    document.write_text(f"{text}{HEADING}\n\n{now}\n\n{figures.read_text().rstrip()}\n")


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
