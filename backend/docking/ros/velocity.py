"""The robot's velocity: `cmd_vel`, and the watchdog that stops a robot whose control steps do not come."""

import math
import threading
import time
import traceback
from collections.abc import Callable

from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.node import Node

from docking.core.observation import STANDSTILL, Odometry, Velocity
from docking.estimation.standstill import Standstill
from docking.ros.other_commands import OtherCommands
from docking.ros.velocity_publisher import VelocityPublisher
from robot_io.halt import PERIOD, Halt

WATCHDOG_TIMEOUT = 0.5
"""Seconds that a motion goes on without being renewed."""
SCAN_PERIOD = 0.1
"""Seconds between two scans for other nodes that drive, while zero velocity is repeated."""
RECENT = 1.0
"""Seconds after a velocity in which the wheels still count as driven by us."""


class Drive:
    """Publishes velocities, and zero when a motion is not renewed in time. A zero is repeated: see `Halt`.

    The thread that spins the node drives; the watchdog's and the process's main thread stop where that thread hangs.
    So one lock is held while a velocity is decided on and published: after a stop, no older velocity comes.

    Attributes:
        publisher: Publishes them.
    """

    def __init__(self, node: Node, odometry: Callable[[], Odometry | None] = lambda: None) -> None:
        """Make the publisher.

        Args:
            node: The node that publishes.
            odometry: The newest odometry; None where there is none.
        """
        self._node = node
        self._odometry = odometry
        self._lock = threading.RLock()
        self._velocity: Velocity | None = None
        self._halt: Halt | None = None
        self._standstill = Standstill()
        self._stopped_at = self._published_at = self._renewed_at = -math.inf
        self.publisher = VelocityPublisher(node)
        self._others = OtherCommands(node)
        self._scans = node.create_timer(SCAN_PERIOD, self._follow_others, clock=Clock(clock_type=ClockType.STEADY_TIME))
        self._scans.cancel()
        self._watchdog = Watchdog(WATCHDOG_TIMEOUT, self._check)

    def begin(self) -> None:
        """A goal takes over, whatever the velocity was before."""
        self.leave()
        self.publisher.add_wanted()
        self._others.listen()

    def follow_graph(self, *, needed: bool) -> None:
        """Follow the subscribers of `cmd_vel`, and those who drive, too; call it once a second.

        Args:
            needed: Whether a goal runs.
        """
        before = self.publisher.mismatch
        if self.recent or not self.publisher.drop_unwanted():
            self.publisher.add_wanted()
        if (mismatch := self.publisher.mismatch) is not None and mismatch != before:
            self._node.get_logger().warning(mismatch)
        if needed:
            self._others.listen()
        elif not self.halting:
            self._others.leave()

    def go(self, velocity: Velocity, decided_at: float) -> None:
        """Publish a velocity. A standstill is repeated until the robot stands, and then the wheels are left to others.

        Args:
            velocity: The commanded velocity until the next call.
            decided_at: The moment of what it was decided on, in seconds of the monotonic clock. A decision that took
                too long, or until after the robot was stopped, moves nothing any more.
        """
        with self._lock:
            if decided_at < self._stopped_at or time.monotonic() - decided_at > WATCHDOG_TIMEOUT:
                velocity = STANDSTILL
            if velocity == STANDSTILL:
                if self._velocity != STANDSTILL:
                    self._begin_halt()
                    self.publisher.publish(STANDSTILL)
                return
            self._halt = None
            self._velocity = velocity
            self._published_at = self._renewed_at = time.monotonic()
            self._watchdog.feed()
            self.publisher.publish(velocity)

    def leave(self) -> None:
        """Leave the wheels to another node. The next standstill is published: that node may have driven."""
        with self._lock:
            self._watchdog.sleep()
            self._velocity = self._halt = None

    def stop(self) -> None:
        """Publish zero velocity, from any thread. It never raises: those who call it have other things to end."""
        with self._lock:
            self._begin_halt()
            self._publish_zero()

    def hold_still(self) -> None:
        """Stop, unless that is done; from any thread."""
        with self._lock:
            if self._velocity != STANDSTILL:
                self.stop()

    @property
    def recent(self) -> bool:
        """Whether a velocity was published a moment ago."""
        return time.monotonic() - self._published_at < RECENT

    @property
    def halting(self) -> bool:
        """Whether zero velocity is being repeated."""
        return self._halt is not None

    def _begin_halt(self) -> None:
        self._velocity = STANDSTILL
        self._stopped_at = self._published_at = time.monotonic()
        self._standstill = Standstill()
        self._halt = Halt(self._stopped_at)
        self._watchdog.feed(PERIOD)
        self._scans.reset()

    def _follow_others(self) -> None:
        """Hear a node that is new on the topic, too: it may be the next to drive, while zero is still repeated."""
        with self._lock:
            if self._halt is None:
                self._scans.cancel()
                return
        self._others.listen()

    def _check(self) -> None:
        """Check, in the watchdog's thread, whether a motion was not renewed, or zero velocity has to be repeated."""
        with self._lock:
            stopped = self._repeat_or_stop(time.monotonic())
        if stopped:
            self._node.get_logger().error(
                f"No control step for {WATCHDOG_TIMEOUT:g} s while the robot moves: stopping it"
            )

    def _repeat_or_stop(self, now: float) -> bool:
        """Repeat zero velocity, or stop a motion that was not renewed; whether it was the latter."""
        if self._halt is not None:
            moves = self._standstill.moves(self._odometry())
            if not self._halt.repeat(now, moves=moves, commanded_at=self._others.heard_at):
                self._halt = None
                return False
            self._published_at = now
            self._publish_zero()
            self._watchdog.feed(PERIOD)
        elif self._velocity not in (None, STANDSTILL):
            if (left := self._renewed_at + WATCHDOG_TIMEOUT - now) > 0.0:  # it was renewed just now
                self._watchdog.feed(left)
                return False
            self.stop()
            return True
        return False

    def _publish_zero(self) -> None:
        try:
            self.publisher.publish(STANDSTILL)
        except Exception:  # noqa: BLE001 - whatever it is, what follows must be done
            self._node.get_logger().fatal(f"Zero velocity could not be published: {traceback.format_exc()}")

    def close(self) -> None:
        """Leave `cmd_vel`, once a robot that was driven a moment ago has been stopped; end the watchdog."""
        if self._velocity not in (None, STANDSTILL):
            self.stop()
        deadline = self._stopped_at + RECENT
        while self.halting and time.monotonic() < deadline:
            time.sleep(PERIOD)
        self._watchdog.close()
        self._halt = None
        self._scans.cancel()
        self._others.leave()
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

    def feed(self, timeout: float | None = None) -> None:
        """Restart the timeout.

        Args:
            timeout: Another one for this time, in seconds.
        """
        with self._changed:
            before, self._deadline = self._deadline, time.monotonic() + (self._timeout if timeout is None else timeout)
            if before is None or self._deadline < before:
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
