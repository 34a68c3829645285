"""Decides which values of a robot's battery states are believed, message by message. No ROS, no clock."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from dock_gateway.core.battery import (
    SURELY_TO_100,
    BatteryReading,
    Doubt,
    PowerSupply,
    doubt_unit,
    doubts,
    fraction,
    measured,
)

# Seconds for which a field must be right again until it is believed: two publishers on one topic may take turns. The
# time doubles each time that the field is wrong again within `RECENT`, up to `MAX_HOLD`.
HOLD = 10.0
MAX_HOLD = 300.0
# Seconds since a field was last wrong.
RECENT = 3600.0
# The stamp of a message, and how far it may be from the gateway's clock, in seconds.
STAMP = "header.stamp"
CLOCK = "header.stamp, moving"
MAX_AGE = 60.0
# Seconds by which the difference to the gateway's clock may change between two stamps, if it is the clock that is off.
STEADY = 30.0
# What a percentage is divided by, at least and at most, when a driver that counted to 100 has been corrected.
CORRECTED = 80.0, 125.0
# Simulators count from 0. A stamp before 1980 is not worth an alert as long as it moves on.
EARLIEST = 315_532_800.0
# Seconds before an alert about a stamp: a clock may be set at the start.
STAMP_GRACE = 10.0


@dataclass
class Held:
    """A doubt that holds: as it was first and as it is now, since when and until when, in seconds."""

    first: Doubt
    latest: Doubt
    since: float
    last: float
    hold: float


class Plausibility:
    """Judges the battery states of one robot.

    Args:
        counts_to_100: Whether its driver counts `percentage` to 100.
        charges_negative: Whether its driver counts a charging current as negative.
    """

    def __init__(self, *, counts_to_100: bool = False, charges_negative: bool = False) -> None:
        self._counts_to_100 = counts_to_100
        self._sign = -1.0 if charges_negative else 1.0
        self._held: dict[str, Held] = {}
        self._past: dict[str, Held] = {}  # the last that ended, by field
        self._percentage = 0.0  # the last that was measured, as sent
        self._seems_to_100 = False
        self._stamp: float | None = None
        self._offset = 0.0  # seconds from the stamp to its first arrival
        self._moves = False  # whether the stamp moves with the clock, apart from that

    def judge(self, state: Mapping[str, Any], now: float, wall: float) -> BatteryReading:
        """Return the plausible values of a state.

        Args:
            state: A BatteryState as JSON. An infinity is a text, such as `inf`.
            now: A monotonic clock, in seconds.
            wall: The time, in seconds since 1970.
        """
        found = {doubt.field.partition(".")[0]: doubt for doubt in doubts(state, counts_to_100=self._counts_to_100)}
        if (unit := self._doubt_unit(state["percentage"])) is not None:
            found.setdefault("percentage", unit)
        stamp = self._doubt_stamp(state.get("header"), wall)
        if stamp is not None:
            found[CLOCK if self._moves else STAMP] = stamp
        self._hold(found, now)
        held = [(field, self._held[field]) for field in sorted(self._held)]
        latest = tuple(each.latest for _, each in held)
        named = tuple(each.first for _, each in held if each.last - each.since >= each.first.grace)
        if stamp is not None and not self._moves:
            return BatteryReading(doubts=latest, named=named)
        fields = self._held.keys()
        current = None if "current" in fields else measured(state, "current")
        return BatteryReading(
            PowerSupply.UNKNOWN if "power_supply_status" in fields else state["power_supply_status"],
            None if "percentage" in fields else fraction(state, counts_to_100=self._counts_to_100),
            None if current is None else self._sign * current,
            latest,
            named,
        )

    def _hold(self, found: Mapping[str, Doubt], now: float) -> None:
        for field, doubt in found.items():
            if (held := self._held.get(field)) is not None:
                held.latest, held.last = doubt, now
                continue
            past = self._past.pop(field, None)
            recent = past is not None and now - past.last < RECENT
            hold = min(MAX_HOLD, 2 * past.hold) if past is not None and recent else HOLD
            self._held[field] = Held(doubt, doubt, now, now, 0.0 if field in (STAMP, CLOCK) else hold)
        for field in self._held.keys() - found.keys():
            if now - self._held[field].last >= self._held[field].hold:
                self._past[field] = self._held.pop(field)

    def _doubt_unit(self, value: object) -> Doubt | None:
        """Return the doubt about a percentage that is in range only as a driver that counts to 100 is below 1 %.

        If it falls to about a hundredth at once, it is the same charge, and the driver has been corrected. 1.0 after 12
        is 1 %: a robot that was out of reach in between is not full.
        """
        if self._counts_to_100 or not isinstance(value, int | float):
            return None
        if value > SURELY_TO_100:
            self._seems_to_100 = True
        elif value > 0 and CORRECTED[0] <= self._percentage / value <= CORRECTED[1]:
            self._seems_to_100 = False
        self._percentage = value
        return doubt_unit(value) if self._seems_to_100 else None

    def _doubt_stamp(self, header: Mapping[str, Any] | None, wall: float) -> Doubt | None:
        """Return the doubt about a stamp that is far from the clock.

        If later stamps are just as far, it is the clock of the robot that is off, and what it measures is new. If not,
        an old measurement is sent again.
        """
        stamp = 0.0 if header is None else header["stamp"]["sec"] + header["stamp"]["nanosec"] / 1e9
        if stamp == 0.0:
            self._stamp = None
            return None
        offset = wall - stamp
        if stamp != self._stamp:
            self._moves = self._stamp is not None and abs(offset - self._offset) <= STEADY
            self._stamp, self._offset = stamp, offset
        elif offset - self._offset > STEADY:
            self._moves = False
        if abs(offset) <= MAX_AGE or (self._moves and stamp < EARLIEST):
            return None
        where = f"{abs(offset):.0f} s {'behind' if offset > 0 else 'ahead of'} the gateway's clock"
        if self._moves:
            advice = f"It is {where}: set the clock of the robot or of the gateway's machine."
        else:
            advice = f"It is {where} and does not move with it, so that the message is not believed at all."
        return Doubt(STAMP, stamp, f"a time within {MAX_AGE:.0f} s of the gateway's clock", advice, STAMP_GRACE)
