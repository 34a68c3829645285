"""How much of its time the hub reads one site: a site that never stops talking is not all."""

import asyncio
import time

# What a site lets the hub work for without a break, in seconds; how many times as long, or how long, others come first
# after that.
LONG_WORK, BREAK, LONGEST_BREAK = 0.005, 3.0, 0.5
# Messages of a site in a second. It is not read on until the next one.
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
