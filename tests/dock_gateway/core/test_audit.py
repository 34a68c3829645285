"""The chain: whatever is done to a row, a row is missing or one too many, it is found."""

from dataclasses import fields, replace
from datetime import timedelta
from typing import Any

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from dock_gateway.core.audit import (
    GENESIS,
    MAX_ROBOTS,
    MAX_TEXT,
    START,
    AuditEntry,
    AuditFilter,
    AuditRow,
    Link,
    RequestOutcome,
    Verdict,
    digest_of,
    extend,
    verify,
)
from tests.support.audit import NOON, make_entry

texts = st.text(max_size=20)
times = st.integers(0, 10**15).map(lambda us: NOON + timedelta(microseconds=us))
VALUES: dict[str, st.SearchStrategy[Any]] = {
    field.name: {"acted_at": times, "status": st.integers(100, 599)}.get(
        field.name, texts if field.type == "str" or field.type is str else st.none() | texts
    )
    for field in fields(AuditEntry)
}
entries = st.builds(AuditEntry, **VALUES)
chains = st.lists(entries, min_size=1, max_size=8).map(lambda each: list(extend(START, each)))


def checked(rows: list[AuditRow], whole: list[AuditRow]) -> Verdict:
    return verify(rows, START, whole[-1].link)


@given(chains)
def test_an_untouched_chain_is_intact(rows: list[AuditRow]) -> None:
    assert checked(rows, rows) == Verdict(len(rows), rows[-1].link)
    for at, row in enumerate(rows):  # the oldest were deleted for their age
        assert verify(rows[at + 1 :], row.link, rows[-1].link) == Verdict(len(rows) - at - 1, rows[-1].link)


@given(chains, st.data())
def test_any_change_of_any_row_is_found(rows: list[AuditRow], data: st.DataObject) -> None:
    at = data.draw(st.integers(0, len(rows) - 1))
    name = data.draw(st.sampled_from([*VALUES, "digest", "sequence"]))
    row = rows[at]
    if name == "digest":
        changed = replace(row, digest=data.draw(st.text("0123456789abcdef", min_size=64, max_size=64)))
    elif name == "sequence":
        changed = replace(row, sequence=data.draw(st.integers(-5, 20)))
    else:
        changed = replace(row, entry=replace(row.entry, **{name: data.draw(VALUES[name])}))
    assume(changed != row)
    verdict = checked(sorted([*rows[:at], changed, *rows[at + 1 :]], key=lambda each: each.sequence), rows)
    assert verdict.fault is not None
    assert verdict.intact <= at or name == "sequence"


@given(chains, st.data())
def test_a_missing_row_is_found(rows: list[AuditRow], data: st.DataObject) -> None:
    at = data.draw(st.integers(0, len(rows) - 1))
    verdict = checked([*rows[:at], *rows[at + 1 :]], rows)
    assert (verdict.intact, verdict.fault) == (at, f"row {at + 1} was removed")


@given(chains, entries, st.data())
def test_an_inserted_row_is_found(rows: list[AuditRow], entry: AuditEntry, data: st.DataObject) -> None:
    """Also one with the right digest, and with all numbers behind it made to fit."""
    at = data.draw(st.integers(0, len(rows)))
    previous = rows[at - 1].link if at else START
    assume(at == len(rows) or rows[at].entry != entry)
    new = AuditRow(at + 1, entry, digest_of(previous.digest, at + 1, entry))
    later = [replace(row, sequence=row.sequence + 1) for row in rows[at:]]
    assert checked([*rows[:at], new, *later], rows).fault is not None


@given(chains, st.data())
def test_swapped_rows_are_found(rows: list[AuditRow], data: st.DataObject) -> None:
    first, second = data.draw(st.integers(0, len(rows) - 1)), data.draw(st.integers(0, len(rows) - 1))
    a, b = rows[first], rows[second]
    assume(a.entry != b.entry)
    rows_now = list(rows)
    rows_now[first], rows_now[second] = replace(a, entry=b.entry), replace(b, entry=a.entry)
    assert checked(rows_now, rows).intact == min(first, second)
    rows_now[first] = replace(b, sequence=a.sequence)  # with their digests
    rows_now[second] = replace(a, sequence=b.sequence)
    assert checked(rows_now, rows).intact == min(first, second)


def test_a_chain_that_was_computed_again_is_shown_by_a_copied_digest() -> None:
    rows = list(extend(START, [make_entry(number) for number in range(5)]))
    forged = list(extend(START, [make_entry(number, principal="eve") for number in range(5)]))
    head = forged[-1].link
    assert verify(forged, START, head).fault is None
    fault = verify(forged, START, head, rows[2].digest).fault
    assert fault is not None
    assert rows[2].digest in fault
    assert verify(rows, START, rows[-1].link, rows[2].digest).fault is None


def test_what_was_deleted_without_an_anchor_is_found() -> None:
    rows = list(extend(START, [make_entry(number) for number in range(5)]))
    assert verify(rows[2:], START, rows[-1].link).fault == "rows 1 to 2 were removed"
    assert verify([], START, rows[-1].link).fault == "rows 1 to 5 were removed"
    assert verify([], START, START) == Verdict(0, START)
    assert verify(rows, START, Link(5, GENESIS)).fault is not None


def test_the_digest_is_the_documented_one() -> None:
    """Computed by hand from the description in docs/extensions/audit_log.md."""
    import hashlib
    import json

    entry = make_entry(1, subject="Schlüssel")
    fields = {**vars(entry), "sequence": 7, "acted_at": "2026-11-21T12:00:01.000000Z"}
    text = json.dumps(fields, sort_keys=True, separators=(",", ":"), ensure_ascii=False)
    assert digest_of(GENESIS, 7, entry) == hashlib.sha256((GENESIS + text).encode()).hexdigest()


def test_a_digest_does_not_depend_on_the_time_zone() -> None:
    from datetime import timezone

    entry = make_entry(1)
    elsewhere = replace(entry, acted_at=entry.acted_at.astimezone(timezone(timedelta(hours=5))))
    assert digest_of(GENESIS, 1, entry) == digest_of(GENESIS, 1, elsewhere)


@pytest.mark.parametrize("text", ["a\0b", "\udcff", "x" * 10_000, "ü" * 1000])
def test_what_clients_send_can_be_stored_anywhere(text: str) -> None:
    entry = make_entry(1, subject=text, robot=text)
    assert entry.subject is not None
    assert entry.robot is not None
    assert len(entry.subject) <= MAX_TEXT
    assert len(entry.robot) <= MAX_ROBOTS
    assert "\0" not in entry.subject
    entry.subject.encode()


@pytest.mark.parametrize(
    ("status", "outcome"), [(200, "done"), (302, "done"), (401, "refused"), (499, "refused"), (500, "failed")]
)
def test_outcomes(status: int, outcome: str) -> None:
    assert make_entry(1, status=status).outcome == outcome


@pytest.mark.parametrize(
    ("wanted", "found"),
    [
        ({}, True),
        ({"principal": "ada"}, True),
        ({"principal": "ad"}, False),
        ({"what": "stop"}, True),
        ({"robot": "/robot2"}, True),
        ({"robot": "/robot"}, False),
        ({"goal_id": "g"}, False),
        ({"outcome": RequestOutcome.DONE}, True),
        ({"outcome": RequestOutcome.REFUSED}, False),
        ({"since": NOON, "until": NOON + timedelta(seconds=1)}, True),
        ({"until": NOON}, False),
        ({"since": NOON + timedelta(seconds=1)}, False),
    ],
)
def test_filters(wanted: dict[str, Any], found: bool) -> None:
    entry = make_entry(0, what="stop", robot="/robot1,/robot2", action_name=None)
    assert AuditFilter(**wanted).matches(entry) is found
