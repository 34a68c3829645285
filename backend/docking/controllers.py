"""Controllers: what moves the robot towards its dock.

A controller is plain Python. It is asked for a velocity ten times a second while a goal runs and is told nothing else
but the time; what a later one needs (a dock's pose, infrared readings) it is given when it is made.
"""

import math
from dataclasses import dataclass
from typing import Protocol


@dataclass(frozen=True)
class Velocity:
    """A velocity of the robot in its own frame (base_link, REP-103: x forward, z up).

    Attributes:
        linear_x: Forward, in m/s.
        angular_z: Counter-clockwise, in rad/s.
    """

    linear_x: float = 0.0
    angular_z: float = 0.0

    @property
    def finite(self) -> bool:
        """Whether it is a velocity at all: neither NaN nor infinite."""
        return math.isfinite(self.linear_x) and math.isfinite(self.angular_z)


STANDSTILL = Velocity()


class Controller(Protocol):
    """Anything that can say how to move now; a new one is made for each goal."""

    def step(self, now: float) -> Velocity:
        """The velocity to drive with until the next step.

        Args:
            now: Seconds of the monotonic clock.
        """


class Rotate:
    """Turns on the spot, as the tutorial does, until the dock is found by luck or by hand."""

    def __init__(self, speed: float = 0.15) -> None:
        self._velocity = Velocity(0.0, speed)

    def step(self, now: float) -> Velocity:
        """The same velocity always: `speed` rad/s, counter-clockwise."""
        return self._velocity
