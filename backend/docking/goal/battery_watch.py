"""Watches for how long the battery has been silent."""

from docking.core.battery import BatteryReading
from docking.parameters import Timeouts

CLOCK_JUMP = 0.5
"""Seconds: a clock that goes back by more has jumped, and a reading that is ahead by more is of another clock."""


class BatteryWatch:
    """Knows which battery message is fresh, and what to say where none is."""

    def __init__(self, timeouts: Timeouts, started_at: float) -> None:
        """Begin with a battery that was heard at the start.

        Args:
            timeouts: When a message is stale, and when the battery is lost.
            started_at: When the goal began.
        """
        self._timeouts = timeouts
        self._heard_at = started_at

    def fresh(self, battery: BatteryReading | None, now: float) -> BatteryReading | None:
        """Take notice of the latest message, and return it unless it is stale, or of another clock."""
        if battery is None or battery.age(now) < -CLOCK_JUMP:
            return None
        self._heard_at = max(self._heard_at, battery.received_at)
        return battery if battery.age(now) <= self._timeouts.battery_stale_after else None

    def describe_loss(self, now: float) -> str:
        """Say that the battery was silent for too long; empty while it was not."""
        lost_after = self._timeouts.battery_lost_after
        return (
            f"no battery message for {lost_after:g} s (battery_lost_after)" if now - self._heard_at > lost_after else ""
        )

    def describe_silence(self, battery: BatteryReading | None, now: float) -> str:
        """Say that the robot waits for a message."""
        if battery is None or battery.age(now) < -CLOCK_JUMP:
            return "no battery message received yet: the robot waits"
        return f"no battery message for over {self._timeouts.battery_stale_after:g} s: the robot waits"
