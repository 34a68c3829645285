"""The wheels of a robot: zero velocity, which is repeated until it has surely arrived, and who commanded what last."""

import asyncio
import logging
import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from statistics import median
from typing import Protocol

from robot_io.halt import Halt

log = logging.getLogger(__name__)

# Seconds between two zeros. Publishing to hundreds of robots takes 20 ms, and a stop has to be answered in that time.
PERIOD = 0.1
# The number of intervals between commands that the usual one is taken from, and the least number of them.
INTERVALS, FEWEST = 5, 3


class ZeroPublisher(Protocol):
    """Publishes zero velocity."""

    def publish_zero(self) -> None:
        """Command zero velocity, immediately."""

    @property
    def subscribers(self) -> int:
        """The number of subscriptions that it reaches now."""


@dataclass(frozen=True, slots=True)
class VelocityCommand:
    """A message on the velocity topic.

    Attributes:
        at: When it arrived, on the monotonic clock.
        motion: Whether it commands a motion.
        publisher: The id of its publisher; None if no command has arrived since the topic was subscribed to.
    """

    at: float
    motion: bool
    publisher: bytes | None = None


class Wheels:
    """Stops one robot, and knows its last command.

    Args:
        port: The robot's velocity topic.
        period: Seconds between two zeros.
        clock: The monotonic clock.

    Attributes:
        last: The last command; None while the topic is not subscribed to.
        catch_up: Takes commands that have arrived and wait. It does not raise.
    """

    def __init__(self, port: ZeroPublisher, *, period: float = PERIOD, clock: Callable[[], float] = time.monotonic):
        self.last: VelocityCommand | None = None
        self.catch_up: Callable[[], None] = _nothing_waits
        self._hearing = threading.Lock()
        self._driver: bytes | None = None  # who moved the robot last, and when: not before it stood last
        self._moved_at: float | None = None
        self._intervals: deque[float] = deque(maxlen=INTERVALS)
        self._port = port
        self._period = period
        self._clock = clock
        self._halt: Halt | None = None
        self._commanded_at = float("-inf")

    def publish_zero(self) -> None:
        """Command zero velocity, and repeat that in the background, see `Halt`.

        Raises:
            Exception: It cannot be published now. It is repeated nevertheless.
        """
        repeats = self._halt is not None
        self._halt = Halt(self._clock(), self._port.subscribers)
        if not repeats:
            asyncio.get_running_loop().call_later(self._period, self._repeat)
        self._port.publish_zero()

    def _repeat(self) -> None:
        if (halt := self._halt) is None:
            return
        subscribers = self._port.subscribers
        due = halt.repeat(self._clock(), moves=False, commanded_at=self._commanded_at, subscribers=subscribers)
        if halt.over:
            self._halt = None
            return
        asyncio.get_running_loop().call_later(self._period, self._repeat)
        if not due:
            return
        try:
            self._port.publish_zero()
        except Exception as error:  # noqa: BLE001 - the failure of the first one was reported
            log.debug("zero velocity could not be repeated: %s", error)

    def leave(self) -> None:
        """Repeat zero velocity no longer: a goal drives the robot, or it is gone."""
        self._halt = None

    @property
    def interval(self) -> float:
        """The usual seconds between two commands of the node that moves the robot; 0 if that is not known."""
        with self._hearing:
            return median(self._intervals) if len(self._intervals) >= FEWEST else 0.0

    def listen(self) -> None:
        """Note that the topic is subscribed to. The last command before is not known: it may be a motion."""
        self.last = VelocityCommand(self._clock(), motion=True)

    def hear(self, motion: bool, publisher: bytes, at: float) -> None:
        """Note a command, unless a later one is known; on any thread.

        Args:
            motion: Whether it commands a motion.
            publisher: The id of its publisher.
            at: When it arrived, on the monotonic clock.
        """
        with self._hearing:
            if self.last is not None and at < self.last.at:
                return
            self.last = VelocityCommand(at, motion, publisher)
            if motion and publisher != self._driver:
                self._driver, self._moved_at = publisher, None
                self._intervals.clear()
            if motion and self._moved_at is not None:
                self._intervals.append(at - self._moved_at)
            if motion:
                self._commanded_at = at
            if publisher == self._driver:
                self._moved_at = at if motion else None

    def stop_listening(self) -> None:
        """Note that the topic is not subscribed to any more."""
        self.last = self._moved_at = None
        self.catch_up = _nothing_waits


def _nothing_waits() -> None:
    """Nothing is listened to."""
