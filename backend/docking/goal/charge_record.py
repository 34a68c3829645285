"""How often a charge has begun and broken off."""

import math

from docking.core.battery import BatteryReading, describe_status

FLICKERS = 3
"""A charge that has broken off so often flickers."""


class ChargeRecord:
    """Keeps count of the charges of one goal.

    Attributes:
        breaks: Number of charges that broke off.
    """

    def __init__(self, stable_for: float) -> None:
        """Begin with no charge.

        Args:
            stable_for: How long a charge must last, in s.
        """
        self.breaks = 0
        self._stable_for = stable_for
        self._first_at = self._broke_at = math.nan
        self._began_at: float | None = None
        self._longest = 0.0
        self._current = math.nan
        self._highest = math.nan
        self._status = 0

    @property
    def flickers(self) -> bool:
        """Whether the charge comes and goes."""
        return self.breaks >= FLICKERS

    def hear(self, now: float, reading: BatteryReading, *, charges: bool) -> None:
        """Take notice of a battery reading.

        Args:
            now: The moment.
            reading: What the battery says.
            charges: Whether it charges by that.
        """
        self._status, self._current = reading.status, reading.current
        if charges:
            if self._began_at is None:
                self._began_at = now
                self._first_at = self._first_at if self.breaks else now
            self._highest = max(
                reading.current, self._highest, key=lambda current: (not math.isnan(current), abs(current))
            )
        elif self._began_at is not None:
            self.breaks += 1
            self._broke_at, self._longest = now, max(self._longest, now - self._began_at)
            self._began_at = None

    def describe(self) -> str:
        """What became of the charges, as half a sentence; empty where none broke off."""
        if not self.breaks:
            return ""
        if self.breaks == 1:
            what = "broke off once"
        else:
            what = f"flickered: it broke off {self.breaks} times within {self._broke_at - self._first_at:.1f} s"
        now = "" if math.isnan(self._current) else f", the current {self._current:.3g} A"
        then = "" if math.isnan(self._highest) else f", and up to {self._highest:.3g} A while it charged"
        return (
            f"the charge {what}, after {self._longest:.1f} s at most (charge_stable_for is {self._stable_for:g} s); the"
            f" status is now {describe_status(self._status)}{now}{then}. Are the contacts clean?"
        )
