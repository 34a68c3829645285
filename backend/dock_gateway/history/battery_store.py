"""Battery events in buckets, reckoned up by the database: much is read there, and little comes here."""

from typing import Any

import sqlalchemy as sa

from dock_gateway.events import STAMP_DIGITS, Event
from dock_gateway.history.buckets import FIELDS, BatterySpan, Bucket, Buckets, Tally
from dock_gateway.history.rows import event_of
from dock_gateway.history.tables import IS_BATTERY, events

_STAMP = sa.func.substr(events.c.id, 1, STAMP_DIGITS)
_STATUS = "power_supply_status"
_RECKON = (sa.func.count, sa.func.sum, sa.func.min, sa.func.max)  # as Tally has it


def battery(connection: sa.Connection, span: BatterySpan, until: str) -> tuple[Buckets, list[Event]]:
    """The battery events of a span: those before the event `until` in buckets, those after it as they are."""
    first, last = span.ids
    of_robot = (IS_BATTERY, events.c.robot == span.robot)
    early = sa.and_(*of_robot, events.c.id >= first, events.c.id < min(last, until))
    late = sa.select(events).where(*of_robot, events.c.id >= max(first, until), events.c.id < last)
    buckets = {row[0]: _bucket(row) for row in connection.execute(_reckoning(connection, early, span.step))}
    return buckets, [event_of(row) for row in connection.execute(late).mappings()]


def _reckoning(connection: sa.Connection, chosen: "sa.ColumnElement[bool]", step: int) -> "sa.Select[Any]":
    read = _read_in_postgresql if connection.dialect.name == "postgresql" else _read_in_sqlite
    bucket = sa.cast(_STAMP, sa.BigInteger) // sa.literal(step, sa.BigInteger)
    sample = read(_STAMP.label("stamp"), bucket.label("bucket")).where(chosen).subquery()
    # The last status is that of the greatest stamp; all stamps are of one length.
    last = sa.func.max(sample.c.stamp.concat(sample.c[_STATUS]))
    reckoned = [reckon(sample.c[name]) for name in FIELDS for reckon in _RECKON]
    return sa.select(sample.c.bucket, last, *reckoned).group_by(sample.c.bucket)


def _read_in_sqlite(*columns: "sa.ColumnElement[Any]") -> "sa.Select[Any]":
    fields = (sa.func.json_extract(events.c.data, f"$.battery.{name}").label(name) for name in (*FIELDS, _STATUS))
    return sa.select(*columns, *fields)


def _read_in_postgresql(*columns: "sa.ColumnElement[Any]") -> "sa.Select[Any]":
    # A record is read out of the text once; an operator for each field would read it each time.
    types = [*(sa.column(name, sa.Double) for name in FIELDS), sa.column(_STATUS, sa.Text)]
    state = sa.func.json_to_record(sa.cast(events.c.data, sa.JSON)["battery"])
    record = state.table_valued(*types).render_derived(with_types=True).lateral()
    return sa.select(*columns, *record.c).select_from(events.join(record, sa.true()))


def _bucket(row: "sa.Row[Any]") -> Bucket:
    _, last, *reckoned = tuple(row)
    bucket = Bucket(int(last[:STAMP_DIGITS]), int(last[STAMP_DIGITS:]))
    for place, name in enumerate(FIELDS):
        count, total, low, high = reckoned[place * len(_RECKON) :][: len(_RECKON)]
        bucket.tallies[name] = Tally(count, total or 0.0, low, high)
    return bucket
