"""Battery states of a span of time, in buckets of equal length: what a plot needs, whatever there is. Pure."""

from collections.abc import Iterable
from dataclasses import dataclass, field

import orjson

from dock_gateway.events import STAMP_DIGITS, Event, time_id

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
