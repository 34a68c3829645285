"""The tables of docking, which the benchmark writes between two comments of a page each.

The one of usual robots, and the list of rows that dock less, are in docs/docking-results.md; all rows are beside this
module, in results.md.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path

from benchmarks.docking.cases import CASES_BY_NAME
from benchmarks.docking.table import markdown
from benchmarks.docking.worlds import WORLDS

PAGE = Path(__file__).parents[2] / "docs" / "docking-results.md"
RESULTS = Path(__file__).with_name("results.md")
ENOUGH = 95.0
"""A row that docks less, in %, is named in words."""
STATISTICS, BELOW = "statistics", "below"
"""The names of the table of usual robots, and of the list of these rows."""
SEEDS = {
    STATISTICS: range(300),
    "robustness": range(500000, 500024),
    "laws": range(500000, 500040),
    "physics": range(500000, 500060),
}
"""The starts of each table: of each controller, or of each row."""

Row = dict[str, str]
Rows = dict[tuple[str, str], Row]
"""By their first two cells: the other cells by column."""


def with_part(page: str, name: str, text: str) -> str:
    """A page with the text of one of its parts replaced.

    Raises:
        ValueError: The page has no such part.
    """
    begin, end = _edges(name)
    before, found, rest = page.partition(begin)
    _, closed, after = rest.partition(end)
    if not found or not closed:
        raise ValueError(f"no {begin} … {end} in the page")
    return f"{before}{begin}\n\n{text.strip()}\n\n{end}{after}"


def part_of(page: str, name: str) -> str:
    """The text of one part of a page; empty if it has none."""
    begin, end = _edges(name)
    return page.partition(begin)[2].partition(end)[0].strip()


def rows_in(table: str) -> Rows:
    """The rows of a Markdown table."""
    lines = [[cell.strip() for cell in line.strip("| ").split(" | ")] for line in table.splitlines()]
    head = lines[0] if lines else []
    return {(line[0], line[1]): dict(zip(head[2:], line[2:], strict=True)) for line in lines[2:]}


def table_of(rows: Mapping[tuple[str, str], Row], heads: tuple[str, str], order: Sequence[tuple[str, str]]) -> str:
    """Rows as a Markdown table, in an order. Rows that are not in it are left out; a cell that is missing is empty."""
    shown = [key for key in order if key in rows]
    columns = list(dict.fromkeys(column for key in reversed(shown) for column in rows[key]))
    return markdown(
        [[*heads, *columns], *([*key, *(rows[key].get(column, "") for column in columns)] for key in shown)]
    )


def with_list(page: str, results: str) -> str:
    """A page with the list of rows of the results that dock less than 95 % renewed: a line for each reason."""
    found = [
        (name, controller, row, CASES_BY_NAME[name].why)
        for (controller, name), row in rows_in(part_of(results, "robustness")).items()
    ]
    found += [
        (name, "in MuJoCo", row, WORLDS[name][1].why)
        for (name, law), row in rows_in(part_of(results, "physics")).items()
        if law == "ours"
    ]
    lines: dict[str, list[str]] = {}
    for name, where, row, why in found:
        if is_low(row):
            lines.setdefault(why, []).append(f"*{name}* ({where}, {row['docked']})")
    return with_part(page, BELOW, "\n".join(f"- {', '.join(rows)}. {why}".rstrip() for why, rows in lines.items()))


def is_low(row: Row) -> bool:
    """Whether less than 95 % of the goals of a row docked."""
    return float(row["docked"].split()[0]) < ENOUGH


def empty_part(name: str) -> str:
    """A page with nothing but one part, which is empty."""
    begin, end = _edges(name)
    return f"{begin}\n{end}\n"


def _edges(name: str) -> tuple[str, str]:
    return f"<!-- {name}: made by the benchmark -->", f"<!-- end of {name} -->"
