"""Limits of velocity and acceleration, kept in one place."""

import math

from docking.core.observation import STANDSTILL, Velocity
from docking.parameters import MotionLimits

LONGEST_STEP = 0.2
"""In s; after a longer pause the robot does not change its velocity by more than in this time."""
PULSE = 0.2
"""How long the base turns at its slowest, in s, where it is to turn slower than that."""


class Limiter:
    """Bends a wish into what the robot may do next; remembers what it said last."""

    def __init__(self, limits: MotionLimits) -> None:
        self.limits = limits
        self._last = STANDSTILL
        self._owed = 0.0  # rad that were to be turned, and too slowly for the base
        self._pulsing = False

    def limit(self, wish: Velocity, dt: float, dead_zone: Velocity = STANDSTILL) -> Velocity:
        """The velocity next to a wish that keeps all limits.

        Where the base does not turn as slowly as it is to, it turns on and off, and the mean is right.

        Args:
            wish: What a controller wants.
            dt: Seconds since the last velocity.
            dead_zone: Smaller velocities do not move the base, as far as is known.
        """
        limits, dt = self.limits, min(dt, LONGEST_STEP)
        slowest = max(limits.v_linear_min, dead_zone.linear_x)
        linear, angular = wish.linear_x, self._pulse(wish.angular_z, max(limits.v_angular_min, dead_zone.angular_z), dt)
        if 0.0 < abs(linear) < slowest:
            linear = math.copysign(slowest, linear)
        self._last = Velocity(
            _towards(self._last.linear_x, linear, limits.v_linear_max, limits.a_linear_max * dt),
            _towards(self._last.angular_z, angular, limits.v_angular_max, limits.a_angular_max * dt),
        )
        return self._last

    def _pulse(self, wish: float, slowest: float, dt: float) -> float:
        if abs(wish) >= slowest:
            self._owed, self._pulsing = 0.0, False
            return wish
        self._owed += wish * dt
        if not self._pulsing:
            self._pulsing = abs(self._owed) >= PULSE * slowest
            return 0.0
        sign = math.copysign(1.0, self._owed)
        self._owed -= sign * slowest * dt
        self._pulsing = self._owed * sign > 0.0
        return sign * slowest

    def stop(self) -> Velocity:
        """Stand still at once: a stop is never delayed."""
        self._last = STANDSTILL
        self._owed, self._pulsing = 0.0, False
        return STANDSTILL


def _towards(last: float, wish: float, most: float, change: float) -> float:
    lowest, highest = max(-most, last - change), min(most, last + change)
    return min(max(wish, lowest), highest)
