"""The clock of the simulated robot: that of its node, or one of its own that it publishes on `/clock`."""

import math

from builtin_interfaces.msg import Time as TimeMessage
from rclpy.node import Node
from rclpy.time import Time
from rosgraph_msgs.msg import Clock

from docking.simulation.timekeeper import Timekeeper
from robot_io.endpoints import overridable_publisher

LONGEST_LAPSE = 0.25
"""The most time, in s, that is caught up with; the simulation stands still while the process does."""
LONGEST_STEP = 1.0 / 15.0
"""The same with a clock of its own: what drives the robot may be as late as the simulation, so that both slow down."""
RECOVERS = 0.25
"""Lost time, in s, that a clock of its own makes up for."""
IDLE_PERIOD = 0.2
"""Seconds between two messages on `/clock` while nothing drives the robot."""
IDLE_AFTER = 20.0
"""Simulated seconds without a command after which nothing drives it: no server waits longer for the sight of a dock."""


class SimulatorClock:
    """Says how much time passes at each step, and stamps messages.

    A clock of its own begins with real time. It passes more slowly where the machine does not keep up, and is set to
    real time again once the machine does and nothing drives the robot: a server that has just got a goal has no less
    time to find its dock.
    """

    def __init__(self, node: Node, now: float, *, publishes: bool) -> None:
        """Begin.

        Args:
            node: The simulator.
            now: Monotonic seconds.
            publishes: Whether the clock is one of its own.
        """
        self._node = node
        self._publisher = overridable_publisher(node, Clock, "/clock", 1) if publishes else None
        self._keeper = Timekeeper(now, LONGEST_STEP, RECOVERS) if publishes else Timekeeper(now, LONGEST_LAPSE, 0.0)
        self._nanoseconds: int = node.get_clock().now().nanoseconds
        self._published_at = -math.inf
        self._idle_for = math.inf

    @property
    def rate(self) -> float:
        """The share of real time that passes in the simulation; 1 where the machine keeps up."""
        return self._keeper.rate

    @property
    def keeps_up(self) -> bool:
        """Whether the machine is fast enough for the simulation."""
        return self._keeper.keeps_up

    def step(self, now: float, *, driven: bool) -> float:
        """Return the seconds that pass in this step.

        Args:
            now: Monotonic seconds.
            driven: Whether a command has come since the last step.
        """
        lapse = self._keeper.step(now)
        if self._publisher is None:
            return lapse
        self._idle_for = 0.0 if driven else self._idle_for + lapse
        idle = self._idle_for > IDLE_AFTER
        caught_up = self._keeper.catch_up() if idle and self._keeper.keeps_up else 0.0
        self._nanoseconds += round(1e9 * (lapse + caught_up))
        if now - self._published_at >= (IDLE_PERIOD if idle else 0.0):
            self._published_at = now
            self._publisher.publish(Clock(clock=self.stamp()))
        return lapse

    def stamp(self, ago: float = 0.0) -> TimeMessage:
        """Return a moment as the stamp of a message.

        Args:
            ago: How long ago it was, in s.
        """
        own = self._publisher is not None
        now = self._nanoseconds if own else self._node.get_clock().now().nanoseconds
        return Time(nanoseconds=max(0, now - round(1e9 * ago))).to_msg()
