"""Measures rows of a table in several processes; each row is kept in a Markdown file once it is done."""

import math
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import groupby
from multiprocessing import Pool
from pathlib import Path

from benchmarks.docking.page import Row, part_of, rows_in, table_of, with_part
from benchmarks.docking.trial import Trial

Key = tuple[str, str]
"""The first two cells of a row."""
Job = tuple[Key, int]
"""A row and a seed."""


@dataclass(frozen=True, slots=True)
class Table:
    """A table with a row for each fault.

    Attributes:
        name: Of its part of the page.
        heads: Of the first two columns.
        keys: Its rows, in their order.
        run: Runs one trial.
        figures: Makes the other cells, by column, of the trials of a row.
    """

    name: str
    heads: tuple[str, str]
    keys: tuple[Key, ...]
    run: Callable[[Job], Trial]
    figures: Callable[[Key, Sequence[Trial]], Row]

    def measure(self, rows: str, seeds: range, processes: int, page: Path, *, missing: bool = False) -> str:
        """Run the rows whose names contain `rows`, and write them into a page; its other rows stay as they are.

        Args:
            rows: Part of the names of the rows, or several parts separated by commas; empty for all.
            seeds: One trial each.
            processes: How many trials run at a time.
            page: A file with a part of this table's name.
            missing: Whether only rows are run that the page does not have.

        Returns:
            The table.
        """
        text = part_of(page.read_text(), self.name)
        known = rows_in(text) if missing else {}
        jobs = [(key, seed) for key in self.keys if _is_chosen(key, rows) and key not in known for seed in seeds]
        with Pool(processes) as pool:
            trials = zip(jobs, pool.imap(self.run, jobs, chunksize=5), strict=True)
            for key, group in groupby(trials, key=lambda done: done[0][0]):
                figures = self.figures(key, [trial for _, trial in group])
                print(" | ".join([*key, *figures.values()]), file=sys.stderr, flush=True)
                text = table_of(rows_in(text) | {key: figures}, self.heads, self.keys)
                page.write_text(with_part(page.read_text(), self.name, text))
        return text


def _is_chosen(key: Key, rows: str) -> bool:
    return any(part.strip() in cell for part in rows.split(",") for cell in key)


def fastest(speeds: Sequence[float]) -> str:
    """The highest of these speeds."""
    return f"{max(speeds):.3f} m/s" if speeds else "-"


def share(part: int, all_of: int) -> str:
    """As a percentage that is never rounded up."""
    percent = 100.0 * part / all_of
    return f"{math.floor(10.0 * percent) / 10.0:g} %"
