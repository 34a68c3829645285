"""Battery events in buckets, reckoned up by the database: much is read there, and little comes here."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

import orjson
import sqlalchemy as sa

from dock_gateway.core.event import STAMP_DIGITS, Event, time_id
from dock_gateway.history.rows import event_of
from dock_gateway.history.tables import IS_BATTERY, events

FIELDS = ("voltage", "percentage", "current", "temperature")


@dataclass(frozen=True)
class BatterySpan:
    """Of which robot, from when on, until before when, and in how long buckets; in nanoseconds since 1970.

    Buckets begin at multiples of their length, so that those of two spans are the same where these overlap.
    """

    robot: str
    since: int
    until: int
    step: int

    @property
    def ids(self) -> tuple[str, str]:
        """Ids of events in the span are equal to the first or after it, and before the second."""
        return time_id(self.since), time_id(self.until)

    def covers(self, event: Event) -> bool:
        """Whether an event is one of these."""
        first, last = self.ids
        return event.topic == "battery" and event.robot == self.robot and first <= (event.id or "") < last


@dataclass
class Tally:
    """What was measured of one field."""

    count: int = 0
    total: float = 0.0
    low: float | None = None
    high: float | None = None

    def add(self, other: "Tally") -> None:
        """Take up what was measured besides."""
        self.count += other.count
        self.total += other.total
        self.low = min((low for low in (self.low, other.low) if low is not None), default=None)
        self.high = max((high for high in (self.high, other.high) if high is not None), default=None)

    @property
    def mean(self) -> float | None:
        """The mean, None where nothing was measured."""
        return self.total / self.count if self.count else None


@dataclass
class Bucket:
    """The battery states within a bucket: the time of the last one, its status, and what was measured."""

    stamp: int = 0
    status: int | None = None
    tallies: dict[str, Tally] = field(default_factory=lambda: {name: Tally() for name in FIELDS})

    def add(self, other: "Bucket") -> None:
        """Take up more."""
        if other.stamp >= self.stamp:
            self.stamp, self.status = other.stamp, other.status
        for name, tally in other.tallies.items():
            self.tallies[name].add(tally)


Buckets = dict[int, Bucket]


def add_events(buckets: Buckets, events: Iterable[Event], step: int) -> list[Bucket]:
    """Put events into their buckets; those, as time goes by."""
    for event in events:
        stamp = int((event.id or "")[:STAMP_DIGITS])
        state = orjson.loads(event.data)["battery"]
        tallies = {name: _measured(state[name]) for name in FIELDS}
        buckets.setdefault(stamp // step, Bucket()).add(Bucket(stamp, state["power_supply_status"], tallies))
    return [bucket for _, bucket in sorted(buckets.items())]


def _measured(value: float | None) -> Tally:
    return Tally() if value is None else Tally(1, value, value, value)


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
