"""Filters the readings of the three infrared receivers: single ones may be wrong or missing."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from docking.core.observation import InfraredReading
from docking.parameters import Receivers

CONFIRMED = 2
"""Readings in a row that must agree before a receiver counts as seeing the beacon, or as not seeing it."""
FARTHEST = 100.0
"""In m; no beacon shines farther."""


@dataclass(frozen=True, slots=True)
class Change:
    """The beacon came into sight, or went out of it.

    Attributes:
        seen: Which of the two.
        before: When the last reading before it was made.
        after: When the first reading after it was made.
    """

    seen: bool
    before: float
    after: float

    @property
    def stamp(self) -> float:
        """The best guess of its moment."""
        return 0.5 * (self.before + self.after)

    @property
    def gap(self) -> float:
        """The time without a measurement, in s."""
        return self.after - self.before


class Sight:
    """Tells whether the beacon is in sight. A change counts once `CONFIRMED` readings in a row agree on it.

    Attributes:
        seen: None before the first `CONFIRMED` readings in a row that agree.
    """

    def __init__(self) -> None:
        self.seen: bool | None = None
        self._same_at = -math.inf  # when it was last as it is
        self._other_at = -math.inf  # when the readings began to say otherwise
        self._others = 0
        self._first: bool | None = None  # before `seen` is known

    def update(self, seen: bool, stamp: float) -> Change | None:
        """Update with a reading; return the change that it confirms, if any."""
        if self.seen is None:
            self._others = self._others + 1 if seen is self._first else 1
            self._first, self._same_at = seen, stamp
            if self._others >= CONFIRMED:
                self.seen, self._others = seen, 0
            return None
        if seen is self.seen:
            self._same_at, self._others = stamp, 0
            return None
        self._others += 1
        if self._others == 1:
            self._other_at = stamp
        if self._others < CONFIRMED:
            return None
        change = Change(seen, self._same_at, self._other_at)
        self.seen, self._same_at, self._others = seen, stamp, 0
        return change


def ranges_of(reading: InfraredReading) -> tuple[float, float, float]:
    """The distances of a reading, in m: infinite if nothing is seen, 0 if it is too near to tell (REP-117)."""
    left, center, right = (_cleaned(distance) for distance in (reading.left, reading.center, reading.right))
    return left, center, right


def _cleaned(distance: float) -> float:
    return math.inf if distance > FARTHEST else max(distance, 0.0)


def find_sector(seen: Sequence[bool | None], receivers: Receivers) -> tuple[float, float] | None:
    """Between which bearings the beacon is, in rad to the left of straight ahead.

    Args:
        seen: Whether the left, the center and the right receiver see the beacon; None if that is not known.
        receivers: How they are mounted.

    Returns:
        The lowest and the highest bearing; None if no receiver sees the beacon, or no bearing fits all of them.
    """
    half, angle = receivers.half, receivers.infrared_receiver_angle
    left, center, right = seen
    if not (left or center or right):
        return None
    lowest, highest = -math.pi, math.pi
    for sees, direction in zip(seen, receivers.directions, strict=True):
        if sees:
            lowest, highest = max(lowest, direction - half), min(highest, direction + half)
    # Where one sees it and its neighbor does not, the neighbor's view ends there.
    if center is False:
        if left and not right:
            lowest = max(lowest, half)
        elif right and not left:
            highest = min(highest, -half)
    elif center:
        if left is False:
            highest = min(highest, angle - half)
        if right is False:
            lowest = max(lowest, half - angle)
    return (lowest, highest) if lowest <= highest else None
