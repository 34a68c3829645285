"""Limits of velocity and acceleration, kept in one place."""

from docking.core.observation import STANDSTILL, Velocity
from docking.parameters import MotionLimits

LONGEST_STEP = 0.2
"""In s; after a longer pause the robot does not change its velocity by more than in this time."""


class Limiter:
    """Bends a wish into what the robot may do next; remembers what it said last."""

    def __init__(self, limits: MotionLimits) -> None:
        self.limits = limits
        self._last = STANDSTILL

    def limit(self, wish: Velocity, dt: float) -> Velocity:
        """The velocity next to a wish that keeps all limits.

        Args:
            wish: What a controller wants.
            dt: Seconds since the last velocity.
        """
        limits, dt = self.limits, min(dt, LONGEST_STEP)
        self._last = Velocity(
            _towards(self._last.linear_x, wish.linear_x, limits.v_linear_max, limits.a_linear_max * dt),
            _towards(self._last.angular_z, wish.angular_z, limits.v_angular_max, limits.a_angular_max * dt),
        )
        return self._last

    def stop(self) -> Velocity:
        """Stand still at once: a stop is never delayed."""
        self._last = STANDSTILL
        return STANDSTILL


def _towards(last: float, wish: float, most: float, change: float) -> float:
    lowest, highest = max(-most, last - change), min(most, last + change)
    return min(max(wish, lowest), highest)
