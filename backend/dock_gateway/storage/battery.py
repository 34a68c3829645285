"""Battery events in buckets. The database aggregates them, so that little data is transferred."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

import orjson
import sqlalchemy as sa

from dock_gateway.core.battery import BOUNDS, PERCENTAGE, fraction, measured
from dock_gateway.core.event import STAMP_DIGITS, Event, time_id
from dock_gateway.storage.rows import event_of
from dock_gateway.storage.tables import IS_BATTERY, events

FIELDS = ("voltage", "percentage", "current", "temperature")


@dataclass(frozen=True)
class BatterySpan:
    """A robot, a time span from `since` to before `until`, and a bucket length; in nanoseconds since 1970.

    Buckets start at multiples of their length, so that overlapping spans have the same buckets. `counts_to_100`:
    whether the robot's percentages are 0 to 100.
    """

    robot: str
    since: int
    until: int
    step: int
    counts_to_100: bool = False

    @property
    def ids(self) -> tuple[str, str]:
        """The range of event ids in the span: first inclusive, second exclusive."""
        return time_id(self.since), time_id(self.until)

    def covers(self, event: Event) -> bool:
        """Return whether this is a battery event of the robot within the span."""
        first, last = self.ids
        return event.topic == "battery" and event.robot == self.robot and first <= (event.id or "") < last


@dataclass
class FieldTally:
    """The aggregate of one field's measurements."""

    count: int = 0
    total: float = 0.0
    low: float | None = None
    high: float | None = None

    def add(self, other: "FieldTally") -> None:
        """Merge another tally into this one."""
        self.count += other.count
        self.total += other.total
        self.low = min((low for low in (self.low, other.low) if low is not None), default=None)
        self.high = max((high for high in (self.high, other.high) if high is not None), default=None)

    @property
    def mean(self) -> float | None:
        """The mean; None without measurements."""
        return self.total / self.count if self.count else None


@dataclass
class Bucket:
    """The battery states in a bucket: time and status of the last one, and the aggregate of each field."""

    stamp: int = 0
    status: int | None = None
    tallies: dict[str, FieldTally] = field(default_factory=lambda: {name: FieldTally() for name in FIELDS})

    def add(self, other: "Bucket") -> None:
        """Merge another bucket into this one."""
        if other.stamp >= self.stamp:
            self.stamp, self.status = other.stamp, other.status
        for name, tally in other.tallies.items():
            self.tallies[name].add(tally)


Buckets = dict[int, Bucket]


def add_events(buckets: Buckets, events: Iterable[Event], span: BatterySpan) -> list[Bucket]:
    """Add events to their buckets; return the buckets in order of time. Values that cannot be right are left out."""
    for event in events:
        stamp = int((event.id or "")[:STAMP_DIGITS])
        state = orjson.loads(event.data)["battery"]["state"]
        tallies = {name: _tally(_believed(state, name, span)) for name in FIELDS}
        buckets.setdefault(stamp // span.step, Bucket()).add(Bucket(stamp, state["power_supply_status"], tallies))
    return [bucket for _, bucket in sorted(buckets.items())]


def _believed(state: dict[str, Any], name: str, span: BatterySpan) -> float | None:
    return fraction(state, counts_to_100=span.counts_to_100) if name == "percentage" else measured(state, name)


def _tally(value: float | None) -> FieldTally:
    return FieldTally() if value is None else FieldTally(1, value, value, value)


def has_battery(connection: sa.Connection, robot: str) -> bool:
    """Return whether a battery state of a robot is stored."""
    return bool(connection.scalar(sa.select(sa.exists().where(IS_BATTERY, events.c.robot == robot))))


_STAMP = sa.func.substr(events.c.id, 1, STAMP_DIGITS)
_STATUS = "power_supply_status"
_RECKON = (sa.func.count, sa.func.sum, sa.func.min, sa.func.max)  # in the order of the fields of Tally


def battery(connection: sa.Connection, span: BatterySpan, until: str) -> tuple[Buckets, list[Event]]:
    """Return the battery events of a span: those before the id `until` in buckets, the rest one by one."""
    first, last = span.ids
    of_robot = (IS_BATTERY, events.c.robot == span.robot)
    early = sa.and_(*of_robot, events.c.id >= first, events.c.id < min(last, until))
    late = sa.select(events).where(*of_robot, events.c.id >= max(first, until), events.c.id < last)
    buckets = {row[0]: _bucket(row) for row in connection.execute(_reckoning(connection, early, span))}
    return buckets, [event_of(row) for row in connection.execute(late).mappings()]


def _reckoning(connection: sa.Connection, chosen: "sa.ColumnElement[bool]", span: BatterySpan) -> "sa.Select[Any]":
    read = _read_in_postgresql if connection.dialect.name == "postgresql" else _read_in_sqlite
    bucket = sa.cast(_STAMP, sa.BigInteger) // sa.literal(span.step, sa.BigInteger)
    sent = read(_STAMP.label("stamp"), bucket.label("bucket")).where(chosen).subquery()
    believed = [_believed_column(sent.c, name, span).label(name) for name in FIELDS]
    sample = sa.select(sent.c.stamp, sent.c.bucket, sent.c[_STATUS], *believed).subquery()
    # The last status is that of the greatest stamp; all stamps have the same length.
    last = sa.func.max(sample.c.stamp.concat(sample.c[_STATUS]))
    reckoned = [reckon(sample.c[name]) for name in FIELDS for reckon in _RECKON]
    return sa.select(sample.c.bucket, last, *reckoned).group_by(sample.c.bucket)


def _believed_column(sent: Any, name: str, span: BatterySpan) -> "sa.ColumnElement[Any]":
    """Return `_believed` as SQL."""
    value = sent[name]
    if name != "percentage":
        return sa.case((value.between(BOUNDS[name].low, BOUNDS[name].high), value))
    share = value / 100.0 if span.counts_to_100 else value
    unmeasured = sa.and_(value == 0, sa.func.coalesce(sent["voltage"], 1.0) == 0)
    outside = sa.or_(value < PERCENTAGE.low, share > PERCENTAGE.high)
    return sa.case((sa.or_(unmeasured, outside), sa.null()), (share < 0, 0.0), (share > 1, 1.0), else_=share)


def _read_in_sqlite(*columns: "sa.ColumnElement[Any]") -> "sa.Select[Any]":
    fields = (sa.func.json_extract(events.c.data, f"$.battery.state.{name}").label(name) for name in (*FIELDS, _STATUS))
    return sa.select(*columns, *fields)


def _read_in_postgresql(*columns: "sa.ColumnElement[Any]") -> "sa.Select[Any]":
    # Parses the JSON once; one operator per field would parse it each time.
    types = [*(sa.column(name, sa.Double) for name in FIELDS), sa.column(_STATUS, sa.Text)]
    state = sa.func.json_to_record(sa.cast(events.c.data, sa.JSON)["battery", "state"])
    record = state.table_valued(*types).render_derived(with_types=True).lateral()
    return sa.select(*columns, *record.c).select_from(events.join(record, sa.true()))


def _bucket(row: "sa.Row[Any]") -> Bucket:
    _, last, *reckoned = tuple(row)
    bucket = Bucket(int(last[:STAMP_DIGITS]), int(last[STAMP_DIGITS:]))
    for place, name in enumerate(FIELDS):
        count, total, low, high = reckoned[place * len(_RECKON) :][: len(_RECKON)]
        bucket.tallies[name] = FieldTally(count, total or 0.0, low, high)
    return bucket
