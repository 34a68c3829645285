"""The robot's velocity: `cmd_vel`, and the watchdog that stops a robot whose control steps do not come."""

import math
import threading
import time
import traceback
from collections.abc import Callable

from rclpy.node import Node

from docking.core.observation import STANDSTILL, Velocity
from docking.ros.velocity_publisher import VelocityPublisher

WATCHDOG_TIMEOUT = 0.5
"""Seconds that a motion goes on without being renewed."""
RECENT = 1.0
"""Seconds after a velocity in which the wheels still count as driven by us."""


class Drive:
    """Publishes velocities, and zero when a motion is not renewed in time.

    The thread that spins the node calls `go` and `stop`. The watchdog has a thread of its own, so that it works where
    that thread hangs; it only publishes, which rclpy allows from any thread.

    Attributes:
        publisher: Publishes them.
    """

    def __init__(self, node: Node) -> None:
        """Make the publisher.

        Args:
            node: The node that publishes.
        """
        self._node = node
        self._velocity: Velocity | None = None
        self._stopped_at = self._published_at = -math.inf
        self.publisher = VelocityPublisher(node)
        self._watchdog = Watchdog(WATCHDOG_TIMEOUT, self._stop_left_alone)

    def begin(self) -> None:
        """A goal takes over, whatever the velocity was before."""
        self._velocity = None
        self.publisher.add_wanted()

    def look_again(self) -> None:
        """Follow the subscribers of `cmd_vel`; call it once a second."""
        before = self.publisher.mismatch
        if self.recent or not self.publisher.drop_unwanted():
            self.publisher.add_wanted()
        if (mismatch := self.publisher.mismatch) is not None and mismatch != before:
            self._node.get_logger().warning(mismatch)

    def go(self, velocity: Velocity, decided_at: float) -> None:
        """Publish a velocity, but a standstill only once: while a goal waits, the wheels are left to others.

        Args:
            velocity: The commanded velocity until the next call.
            decided_at: The moment of what it was decided on, in seconds of the monotonic clock. A decision that took
                too long, or until after the robot was stopped, moves nothing any more.
        """
        if decided_at < self._stopped_at or time.monotonic() - decided_at > WATCHDOG_TIMEOUT:
            velocity = STANDSTILL
        if velocity == STANDSTILL:
            self._watchdog.sleep()
            if self._velocity == STANDSTILL:
                return
        else:
            self._watchdog.feed()
        self._velocity = velocity
        self._published_at = time.monotonic()
        self.publisher.publish(velocity)

    def leave(self) -> None:
        """Leave the wheels to another node. The next standstill is published: that node may have driven."""
        self._watchdog.sleep()
        self._velocity = None

    def stop(self) -> None:
        """Publish zero velocity, from any thread. It never raises: those who call it have other things to end."""
        self._watchdog.sleep()
        self._velocity = STANDSTILL
        self._publish_zero()

    @property
    def recent(self) -> bool:
        """Whether a velocity was published a moment ago."""
        return time.monotonic() - self._published_at < RECENT

    def _stop_left_alone(self) -> None:
        self._publish_zero()
        self._node.get_logger().error(f"No control step for {WATCHDOG_TIMEOUT:g} s while the robot moves: stopping it")

    def _publish_zero(self) -> None:
        self._stopped_at = self._published_at = time.monotonic()
        try:
            self.publisher.publish(STANDSTILL)
        except Exception:  # noqa: BLE001 - whatever it is, what follows must be done
            self._node.get_logger().fatal(f"Zero velocity could not be published: {traceback.format_exc()}")

    def close(self) -> None:
        """End the watchdog, and leave `cmd_vel`."""
        self._watchdog.close()
        self.publisher.close()


class Watchdog:
    """Calls a function once each time that it was not fed within a timeout."""

    def __init__(self, timeout: float, on_silence: Callable[[], None]) -> None:
        """Start the thread, with the watchdog asleep.

        Args:
            timeout: Seconds without a feed.
            on_silence: Called in the watchdog's thread; it must not raise.
        """
        self._timeout = timeout
        self._on_silence = on_silence
        self._deadline: float | None = None
        self._closed = False
        self._changed = threading.Condition()
        self._thread = threading.Thread(target=self._watch, name="watchdog", daemon=True)
        self._thread.start()

    def feed(self) -> None:
        """Restart the timeout."""
        with self._changed:
            asleep, self._deadline = self._deadline is None, time.monotonic() + self._timeout
            if asleep:
                self._changed.notify()

    def sleep(self) -> None:
        """Suspend the timeout until the next feed."""
        with self._changed:
            self._deadline = None

    def close(self) -> None:
        """End the thread."""
        with self._changed:
            self._closed = True
            self._changed.notify()
        self._thread.join()

    def _watch(self) -> None:
        while self._wait():
            self._on_silence()

    def _wait(self) -> bool:
        """Wait for the timeout or for `close`; return whether it was the timeout."""
        with self._changed:
            while not self._closed:
                if self._deadline is None:
                    self._changed.wait()
                elif (left := self._deadline - time.monotonic()) > 0.0:
                    self._changed.wait(left)
                else:
                    self._deadline = None
                    return True
            return False
