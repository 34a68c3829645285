"""How fast the time of a simulation passes: as real time does, or slower where the machine is too slow for that."""

WINDOW = 2.0
"""Seconds over which the rate is measured."""
AS_GOOD_AS_REAL = 0.95
"""A rate from which on the simulation keeps up: no machine is always on time."""


class Timekeeper:
    """Says at each step how much time to simulate, and measures what share of real time that was.

    Attributes:
        lag: Seconds by which the simulation is behind real time.
        rate: Simulated seconds per second, lately; 1 where it keeps up.
    """

    def __init__(self, now: float, longest: float, recovers: float) -> None:
        """Begin.

        Args:
            now: Seconds of a clock that never jumps.
            longest: The most time to simulate in one step, in s: less than has passed where steps come late.
            recovers: How much lost time the next steps make up for, in s.
        """
        self.lag = 0.0
        self.rate = 1.0
        self._longest, self._recovers = longest, recovers
        self._owed = 0.0
        self._at = self._measured_at = now
        self._simulated = 0.0

    @property
    def keeps_up(self) -> bool:
        """Whether the machine is fast enough."""
        return self.rate >= 1.0

    def step(self, now: float) -> float:
        """Return the seconds to simulate.

        Args:
            now: Seconds of the same clock.
        """
        passed, self._at = now - self._at, now
        due = passed + self._owed
        lapse = min(self._longest, due)
        self._owed = min(self._recovers, due - lapse)
        self.lag += passed - lapse
        self._measure(now, lapse)
        return lapse

    def catch_up(self) -> float:
        """Return the seconds that the simulation is behind, which then count as over: nothing happened in them."""
        behind, self.lag, self._owed = max(0.0, self.lag), 0.0, 0.0
        return behind

    def _measure(self, now: float, lapse: float) -> None:
        self._simulated += lapse
        passed = now - self._measured_at
        if passed >= WINDOW:
            rate = self._simulated / passed
            self.rate = 1.0 if rate >= AS_GOOD_AS_REAL else round(rate, 2)
            self._measured_at, self._simulated = now, 0.0
