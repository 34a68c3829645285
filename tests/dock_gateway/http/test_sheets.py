"""Goals and messages as CSV: readable by spreadsheets, and never carried out by them."""

import csv
import io
import unicodedata
from datetime import timedelta
from typing import Any

import orjson
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dock_gateway.core.goal import GoalError, GoalStatus
from dock_gateway.http.sheets import (
    GOAL_COLUMNS,
    MAX_ITEMS,
    NUMBER,
    FeedbackSheet,
    cell,
    flatten,
    goal_row,
    rows_of,
)
from tests.support.history import NOW, make_goal


def read(data: bytes) -> list[list[str]]:
    return list(csv.reader(io.StringIO(data.decode(), newline="")))


def event(number: int, **feedback: Any) -> bytes:
    return orjson.dumps({"type": "feedback", "id": f"{number}-f", "time": f"t{number}", "feedback": feedback})


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (None, ""),
        (True, "true"),
        (-1.5, "-1.5"),
        (0, "0"),
        ("", ""),
        ('a, "b"\n', 'a, "b"\n'),
        ("=1+1", "'=1+1"),
        ("+cmd|' /C calc'!A0", "'+cmd|' /C calc'!A0"),
        ("-2+3", "'-2+3"),
        ("@SUM(A1)", "'@SUM(A1)"),
        ("\t=1", "'\t=1"),
        ("-12", "-12"),
        ("+1.5e-3", "+1.5e-3"),
        ("-1_0", "'-1_0"),
        ("-", "'-"),
        ("a=1", "a=1"),
        ("\uff1d1+1", "'\uff1d1+1"),
        ("\uff0b1", "'\uff0b1"),
        ("\uff0d1", "'\uff0d1"),
        ("\uff20SUM(1)", "'\uff20SUM(1)"),
        ("\ufe661", "'\ufe661"),
        ("\ufe621", "'\ufe621"),
        ("\ufe631", "'\ufe631"),
        ("\ufe6bSUM(1)", "'\ufe6bSUM(1)"),
        ("\u207c1", "'\u207c1"),
        ("\u208a1", "'\u208a1"),
        ("\u207b1", "'\u207b1"),
        ("\N{MINUS SIGN}1+2", "'\N{MINUS SIGN}1+2"),
        (" =1", "' =1"),
        (" \u00a0\u3000=1", "' \u00a0\u3000=1"),
        ("\u200b\ufeff\u202e\uff1d1", "'\u200b\ufeff\u202e\uff1d1"),
        ("\n=1", "'\n=1"),
        ("\x00\x1b=1", "'\x00\x1b=1"),
        ("\tnot one", "'\tnot one"),
        (" -1", "' -1"),
        ("-\uff11", "'-\uff11"),
        (" a", " a"),
        ("\u200b", "\u200b"),
        ("\u2a751", "'\u2a751"),
        ("≠1", "≠1"),
        ("½", "½"),
        (b'{"order":5}', '{"order":5}'),
        (NOW, "2026-11-21T00:00:00Z"),
    ],
)
def test_cells(value: object, text: str) -> None:
    assert cell(value) == text
    assert read(rows_of([[value, 7]])) == [[text, "7"]]


@given(st.text())
def test_no_cell_is_a_formula(text: str) -> None:
    """However a spreadsheet normalizes it, and whatever it leaves out before."""
    written = cell(text.encode(errors="replace"))
    plain = unicodedata.normalize("NFKC", written).strip().replace("\N{MINUS SIGN}", "-")
    assert not plain.startswith(("=", "+", "-", "@")) or NUMBER.fullmatch(written)


@given(st.floats(allow_nan=False, allow_infinity=False) | st.integers())
def test_numbers_stay_numbers(number: float) -> None:
    assert cell(str(number)) == str(number)


def test_a_row_of_a_goal() -> None:
    goal = make_goal(
        1,
        GoalStatus.ABORTED,
        error=GoalError("failed_to_charge", '=HYPERLINK("x"), €'),
        finished_at=NOW + timedelta(seconds=3.5),
        result=b'{"a":[1]}',
        verb="dock",
    )
    (row,) = read(rows_of([goal_row(goal, ("blocked", "maintenance"))]))
    found = dict(zip(GOAL_COLUMNS, row, strict=True))
    assert (found["goal_id"], found["verb"]) == ("goal-0001", "dock")
    assert (found["status"], found["stalled"], found["stage"]) == ("aborted", "false", "")
    assert (found["error_code"], found["error_detail"]) == ("failed_to_charge", '\'=HYPERLINK("x"), €')
    assert (found["created_at"], found["duration_s"]) == ("2026-11-21T00:00:01Z", "2.5")
    assert (found["goal"], found["result"]) == ('{"order":5}', '{"a":[1]}')
    running = dict(zip(GOAL_COLUMNS, goal_row(make_goal(2, GoalStatus.EXECUTING), ()), strict=True))
    assert (running["duration_s"], running["error_code"], running["finished_at"]) == (None, None, None)


def test_fields_of_a_message() -> None:
    message = {"state": {"voltage": 2.16, "cells": [1, 2], "none": []}, "text": None}
    assert list(flatten(message)) == [
        ("state.voltage", 2.16),
        ("state.cells.0", 1),
        ("state.cells.1", 2),
        ("text", None),
    ]
    long = [0] * (MAX_ITEMS + 1)
    assert list(flatten({"image": long})) == [("image", orjson.dumps(long))]


def test_arrays_that_grow_have_their_columns_together() -> None:
    events = [event(1, cells=[], last=0), event(2, cells=[{"v": 1}], last=1), event(3, cells=[{"v": 2}, {"v": 3}])]
    sheet = FeedbackSheet()
    sheet.add_columns(events[:1])
    sheet.add_columns(events[1:])
    assert read(sheet.head()) == [["time", "id", "last", "cells.0.v", "cells.1.v"]]
    assert read(sheet.rows(events)) == [
        ["t1", "1-f", "0", "", ""],
        ["t2", "2-f", "1", "1", ""],
        ["t3", "3-f", "", "2", "3"],
    ]
    sheet = FeedbackSheet()
    sheet.add_columns(event(number, sequence=list(range(number)), end=1) for number in range(1, 13))
    assert sheet.columns == [*(f"sequence.{number}" for number in range(12)), "end"]


def test_names_of_fields_are_no_formulas() -> None:
    sheet = FeedbackSheet()
    sheet.add_columns([event(1, **{"=1": 2})])
    assert read(sheet.head()) == [["time", "id", "'=1"]]
