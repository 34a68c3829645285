"""Limits the time that the hub spends on the messages of one site."""

import asyncio
import time

# Seconds that the hub reads one site without a break. The break: times as long as it has read, at most so many seconds.
LONG_WORK, BREAK, LONGEST_BREAK = 0.005, 3.0, 0.5
# Maximum number of messages of a site in a second. The rest is read in the next one.
MAX_MESSAGES = 1000


class Pace:
    """The pace at which one site is read."""

    def __init__(self) -> None:
        self._worked = 0.0
        self._second = 0
        self._read = 0

    async def give_way(self, took: float) -> None:
        """Note that a message was read, and let others work.

        Args:
            took: Seconds that it took.
        """
        self._worked += took
        now = time.monotonic()
        if int(now) != self._second:
            self._second, self._read = int(now), 0
        self._read += 1
        pause = 0.0
        if self._worked > LONG_WORK:
            pause = min(BREAK * self._worked, LONGEST_BREAK)
            self._worked = 0.0
        if self._read >= MAX_MESSAGES:
            pause = max(pause, self._second + 1 - now)
        await asyncio.sleep(pause)
