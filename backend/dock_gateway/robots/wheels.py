"""The wheels of a robot: zero velocity, which is repeated until it has surely arrived, and who commanded what last."""

import asyncio
import logging
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from robot_io.halt import Halt

log = logging.getLogger(__name__)

# Seconds between two zeros. Publishing to hundreds of robots takes 20 ms, and a stop has to be answered meanwhile.
PERIOD = 0.1


class VelocityPort(Protocol):
    """Publishes zero velocity."""

    def publish_zero(self) -> None:
        """Command zero velocity, immediately."""


@dataclass(frozen=True, slots=True)
class Command:
    """A message on the velocity topic.

    Attributes:
        at: When it was heard, on the monotonic clock.
        motion: Whether it commands a motion.
        publisher: The id of its publisher; None if none was heard since the topic was subscribed to.
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
    """

    def __init__(self, port: VelocityPort, *, period: float = PERIOD, clock: Callable[[], float] = time.monotonic):
        self.last: Command | None = None
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
        self._halt = Halt(self._clock())
        if not repeats:
            asyncio.get_running_loop().call_later(self._period, self._repeat)
        self._port.publish_zero()

    def _repeat(self) -> None:
        halt = self._halt
        if halt is None or not halt.repeat(self._clock(), moves=False, commanded_at=self._commanded_at):
            self._halt = None
            return
        asyncio.get_running_loop().call_later(self._period, self._repeat)
        try:
            self._port.publish_zero()
        except Exception as error:  # noqa: BLE001 - the failure of the first one was reported
            log.debug("zero velocity could not be repeated: %s", error)

    def leave(self) -> None:
        """Repeat zero velocity no longer: a goal drives the robot, or it is gone."""
        self._halt = None

    def listen(self) -> None:
        """Note that commands are heard from now on. The one before is not known: it may be a motion."""
        self.last = Command(self._clock(), motion=True)

    def hear(self, motion: bool, publisher: bytes) -> None:
        """Note a command; on any thread."""
        self.last = Command(self._clock(), motion, publisher)
        if motion:
            self._commanded_at = self.last.at

    def stop_listening(self) -> None:
        """Note that commands are not heard any more."""
        self.last = None
