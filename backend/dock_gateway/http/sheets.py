"""Goals and messages as rows of a CSV file (RFC 4180). Pure.

Each field of a message is a column, named by its dotted path: `current_battery_state.voltage`, `cell_voltage.0`.
"""

import csv
import io
import re
import unicodedata
from collections.abc import Iterable, Iterator, Sequence
from datetime import datetime
from typing import Any

import orjson

from dock_gateway.core.goal import Goal, encode

NUMBER = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)?", re.ASCII)
# Characters that spreadsheets take for the start of a formula, also where these are wide, small or raised ones.
FORMULA = frozenset("=+-@\N{MINUS SIGN}")
# What they do not show, and some leave out before they look for a formula: spaces, control and format characters.
UNSEEN = ("Z", "C")
# Items. Longer arrays are one column, as JSON.
MAX_ITEMS = 1000

GOAL_COLUMNS = (
    "goal_id",
    "action_name",
    "action_type",
    "verb",
    "status",
    "stalled",
    "origin",
    "stage",
    "retries",
    "error_code",
    "error_detail",
    "created_at",
    "updated_at",
    "finished_at",
    "duration_s",
    "feedback_count",
    "last_event_id",
    "tags",
    "goal",
    "result",
)


def rows_of(rows: Iterable[Sequence[object]]) -> bytes:
    """Encode rows as CSV in UTF-8."""
    text = io.StringIO()
    csv.writer(text).writerows([cell(value) for value in row] for row in rows)
    return text.getvalue().encode()


def cell(value: object) -> str:
    """Return a cell's text. Null is empty; text that a spreadsheet would run as a formula gets a leading apostrophe."""
    if value is None:
        return ""
    if isinstance(value, bool | int | float | datetime):
        return encode(value).decode().strip('"')
    text = value.decode() if isinstance(value, bytes) else str(value)
    return f"'{text}" if looks_like_formula(text) else text


def looks_like_formula(text: str) -> bool:
    """Return whether a spreadsheet could run a text. A plain number is none."""
    if text.startswith(("\t", "\r", "\n")):
        return True
    first = next((each for each in text if not unicodedata.category(each).startswith(UNSEEN)), "")
    return unicodedata.normalize("NFKC", first)[:1] in FORMULA and not NUMBER.fullmatch(text)


def goal_row(goal: Goal, tags: Sequence[str]) -> list[object]:
    """Return a goal's values in the order of `GOAL_COLUMNS`."""
    error = goal.error
    ended = goal.finished_at
    values: dict[str, object] = {name: getattr(goal, name, None) for name in GOAL_COLUMNS}
    values["status"] = goal.status.value
    values["error_code"], values["error_detail"] = error and error.code, error and error.detail
    values["duration_s"] = None if ended is None else (ended - goal.created_at).total_seconds()
    values["tags"] = "; ".join(tags)
    return list(values.values())


def flatten(value: Any, path: str = "") -> Iterator[tuple[str, object]]:
    """Yield the fields of a message with their dotted paths. An empty array yields none."""
    if isinstance(value, dict):
        items: Iterable[tuple[object, Any]] = value.items()
    elif isinstance(value, list) and len(value) <= MAX_ITEMS:
        items = enumerate(value)
    else:
        yield path, encode(value) if isinstance(value, list) else value
        return
    for name, item in items:
        yield from flatten(item, f"{path}.{name}" if path else str(name))


class FeedbackSheet:
    """Feedback events as CSV rows. All events are read once to find the columns, since arrays may grow."""

    def __init__(self) -> None:
        self._tree: dict[str, Any] = {}

    def add_columns(self, events: Iterable[bytes]) -> None:
        """Add the columns of encoded feedback events."""
        for event in events:
            for path, _ in flatten(orjson.loads(event)["feedback"]):
                branch = self._tree
                for name in path.split("."):
                    branch = branch.setdefault(name, {})
                branch[""] = {}

    @property
    def columns(self) -> list[str]:
        """The dotted paths in message order. Items of one array are adjacent."""
        return [*_leaves(self._tree, "")]

    def head(self) -> bytes:
        """Return the header row."""
        return rows_of([["time", "id", *self.columns]])

    def rows(self, events: Iterable[bytes]) -> bytes:
        """Return one row per event."""
        columns = self.columns
        return rows_of(_feedback_row(orjson.loads(event), columns) for event in events)


def _feedback_row(event: dict[str, Any], columns: list[str]) -> list[object]:
    fields = dict(flatten(event["feedback"]))
    return [event["time"], event["id"], *(fields.get(column) for column in columns)]


def _leaves(tree: dict[str, Any], path: str) -> Iterator[str]:
    for name, branch in tree.items():
        if name:
            yield from _leaves(branch, f"{path}.{name}" if path else name)
        else:
            yield path
