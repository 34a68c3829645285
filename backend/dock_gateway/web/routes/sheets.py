"""Goals and messages as rows of a CSV file (RFC 4180). Pure.

A message has a column for each of its fields, dotted: `current_battery_state.voltage`, `cell_voltage.0`.
"""

import csv
import io
import re
from collections.abc import Iterable, Iterator, Sequence
from datetime import datetime
from typing import Any

import orjson

from dock_gateway.core.goal import Goal, encode

NUMBER = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)?")
# What spreadsheets take for the beginning of a formula.
FORMULA = ("=", "+", "-", "@", "\t", "\r")
# Longer arrays are one column, as JSON.
MAX_ITEMS = 1000

GOAL_COLUMNS = (
    "goal_id",
    "action_name",
    "action_type",
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
    "goal",
    "result",
)


def rows_of(rows: Iterable[Sequence[object]]) -> bytes:
    """Rows as a CSV file has them, in UTF-8."""
    text = io.StringIO()
    csv.writer(text).writerows([cell(value) for value in row] for row in rows)
    return text.getvalue().encode()


def cell(value: object) -> str:
    """A value as it stands in a cell: nothing for null; no text that a spreadsheet would carry out as a formula."""
    if value is None:
        return ""
    if isinstance(value, bool | int | float | datetime):
        return encode(value).decode().strip('"')
    text = value.decode() if isinstance(value, bytes) else str(value)
    return f"'{text}" if text.startswith(FORMULA) and not NUMBER.fullmatch(text) else text


def goal_row(goal: Goal) -> list[object]:
    """A goal, in the order of `GOAL_COLUMNS`."""
    error = goal.error
    ended = goal.finished_at
    values: dict[str, object] = {name: getattr(goal, name, None) for name in GOAL_COLUMNS}
    values["status"] = goal.status.value
    values["error_code"], values["error_detail"] = error and error.code, error and error.detail
    values["duration_s"] = None if ended is None else (ended - goal.created_at).total_seconds()
    return list(values.values())


def flatten(value: Any, path: str = "") -> Iterator[tuple[str, object]]:
    """The fields of a message, each with its dotted path; there is none in an empty array."""
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
    """Feedback events as rows. Which columns there are is known once all of them were looked at: arrays may grow."""

    def __init__(self) -> None:
        self._tree: dict[str, Any] = {}

    def look_at(self, events: Iterable[bytes]) -> None:
        """Take up the columns of encoded feedback events."""
        for event in events:
            for path, _ in flatten(orjson.loads(event)["feedback"]):
                branch = self._tree
                for name in path.split("."):
                    branch = branch.setdefault(name, {})
                branch[""] = {}

    @property
    def columns(self) -> list[str]:
        """The paths, in the order of the message: what is in the same array stands together."""
        return [*_leaves(self._tree, "")]

    def head(self) -> bytes:
        """The first row."""
        return rows_of([["time", "id", *self.columns]])

    def rows(self, events: Iterable[bytes]) -> bytes:
        """A row for each event."""
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
