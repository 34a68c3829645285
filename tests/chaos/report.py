"""What a run has measured: printed, and added to the file that `CHAOS_REPORT` names, as a table."""

import os
from pathlib import Path
from typing import Any


def report(title: str, figures: dict[str, Any]) -> None:
    """Tell the figures of one test."""
    rows = [f"| {name} | {value} |" for name, value in figures.items()]
    table = "\n".join([f"### {title}", "", "| | |", "|---|---|", *rows, "", ""])
    print(table)
    if path := os.environ.get("CHAOS_REPORT"):
        with Path(path).open("a") as file:
            file.write(table)
