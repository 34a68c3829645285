"""The time that goals go by: the steady clock, or with `use_sim_time` the clock of the node."""

import math
import time

from rclpy.node import Node

STOPPED_AFTER = 0.5
"""Seconds of real time after which a simulated clock that does not advance has stopped."""
SLOW, SLOW_FOR = 0.8, 5.0
"""A simulated clock that runs at a smaller share of real time for as many seconds is slow."""
LATE = 0.5
"""Seconds between two control steps from which on they come too late to drive a robot."""


def control_time(node: Node) -> float:
    """Seconds that all moments of an `Observation` are given in."""
    clock = node.get_clock()
    return clock.now().nanoseconds / 1e9 if clock.ros_time_is_active else time.monotonic()


class ClockWatch:
    """Sees whether the time of a node stands still, as when a simulation is paused, and whether the machine is slow."""

    def __init__(self, node: Node) -> None:
        """Begin with a clock that runs.

        Args:
            node: The node.
        """
        self._node = node
        self._last = -math.inf
        self._changed_at = time.monotonic()
        self.begin()

    def begin(self) -> None:
        """A goal begins: what was slow before does not count."""
        self._last = -math.inf
        self._passed = self._real = self._latest = 0.0

    @property
    def stopped(self) -> bool:
        """Whether it does; ask at each control step."""
        now, real = control_time(self._node), time.monotonic()
        if now != self._last:
            self._note(now - self._last, real - self._changed_at)
            self._last, self._changed_at = now, real
        return real - self._changed_at > STOPPED_AFTER

    def _note(self, passed: float, real: float) -> None:
        """Note how much time has passed between two steps."""
        if math.isfinite(passed) and real <= STOPPED_AFTER:  # else it is the first step, or the clock stood still
            self._passed, self._real = self._passed + passed, self._real + real
        if math.isfinite(passed):  # a clock that is set forward is no late step
            self._latest = max(self._latest, min(passed, real))

    @property
    def doubt(self) -> str:
        """Why the machine seems to be too slow, as a sentence; empty where it does not."""
        if self._node.get_clock().ros_time_is_active and self._real > SLOW_FOR:
            rate = self._passed / self._real
            if rate < SLOW:
                return f"the simulated clock ran at {rate:.2g} of real time, as on a machine that is too slow"
        if self._latest > LATE:
            return f"the machine is too slow: control steps came up to {self._latest:.1f} s apart"
        return ""
