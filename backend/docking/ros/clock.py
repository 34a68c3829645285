"""The time that goals go by: the steady clock, or with `use_sim_time` the clock of the node."""

import math
import time

from rclpy.node import Node

STOPPED_AFTER = 0.5
"""Seconds of real time after which a simulated clock that does not advance has stopped."""


def control_time(node: Node) -> float:
    """Seconds that all moments of an `Observation` are given in."""
    clock = node.get_clock()
    return clock.now().nanoseconds / 1e9 if clock.ros_time_is_active else time.monotonic()


class ClockWatch:
    """Sees whether the time of a node stands still, as when a simulation is paused."""

    def __init__(self, node: Node) -> None:
        """Begin with a clock that runs.

        Args:
            node: The node.
        """
        self._node = node
        self._last = -math.inf
        self._changed_at = time.monotonic()

    @property
    def stopped(self) -> bool:
        """Whether it does; ask at each control step."""
        now = control_time(self._node)
        if now != self._last:
            self._last, self._changed_at = now, time.monotonic()
        return time.monotonic() - self._changed_at > STOPPED_AFTER
