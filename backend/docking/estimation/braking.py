"""Learns how fast the base slows down: some roll on for long after a command to stop."""

import math
from collections import deque

SPAN = 0.3
"""Seconds over which a deceleration is measured."""
MEMORY = 6.0
"""Seconds of motion before a standstill that are looked at."""
WEAK = 0.6
"""The part of the commanded deceleration below which the base cannot do more."""


class Braking:
    """Looks at each standstill how fast the base has slowed down, and how fast it was to.

    Attributes:
        limit: The highest deceleration of the base, in m/s² or rad/s²; infinite where none was seen.
        shown: The highest deceleration that was commanded and seen, in the same unit; 0 before the first.
    """

    def __init__(self, at_rest: float, least: float) -> None:
        """Know nothing.

        Args:
            at_rest: The speed of a base that has come to a standstill, in m/s or rad/s.
            least: The speed from which a standstill tells anything, and the least deceleration that must have been
                commanded, in 1/s of it.
        """
        self.limit, self.shown = math.inf, 0.0
        self._at_rest, self._least = at_rest, least
        self._moments: deque[tuple[float, float, float]] = deque()  # time, measured, commanded

    def add(self, now: float, measured: float, commanded: float) -> None:
        """Take in the velocity, as measured and as commanded, in m/s or rad/s."""
        moments = self._moments
        if moments and (now <= moments[-1][0] or now > moments[-1][0] + SPAN or measured * moments[-1][1] < 0.0):
            moments.clear()
        moments.append((now, measured, commanded))
        while moments[0][0] < now - MEMORY:
            moments.popleft()
        if abs(measured) < self._at_rest:
            self._learn()
            moments.clear()

    def _learn(self) -> None:
        fastest = max(self._moments, key=lambda moment: abs(moment[1]))[1]
        if abs(fastest) < self._least:
            return
        sign = math.copysign(1.0, fastest)
        wanted, shown = (self._steepest(which, sign) for which in (2, 1))
        if wanted < self._least:
            return  # something else has stopped it
        self.shown = max(self.shown, shown)
        self.limit = shown if shown < WEAK * wanted else math.inf

    def _steepest(self, which: int, sign: float) -> float:
        """The highest deceleration over `SPAN` of the measured (1) or the commanded (2) velocity."""
        steepest, before = 0.0, 0
        moments = [(moment[0], max(0.0, sign * moment[which])) for moment in self._moments]
        for now, speed in moments:
            while moments[before + 1][0] <= now - SPAN:
                before += 1
            began, faster = moments[before]
            if now - began >= SPAN - 1e-6:
                steepest = max(steepest, (faster - speed) / (now - began))
        return steepest
