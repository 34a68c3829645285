"""Shares the event loop's time between connections: what clients send, and what they are sent."""

import asyncio
from collections import deque
from collections.abc import Callable
from time import perf_counter

Work = Callable[[], None]

# Seconds that it costs to send a client a message or a piece of an answer.
SEND_COST = 0.00005
# Seconds that each of its bytes costs in addition.
BYTE_COST = 1e-9


class TurnScheduler:
    """Handles the input and output of connections: now if this turn of the loop has time, else in turn.

    A turn of the loop spends at most `TURN` seconds on both, so one client's flood delays the others by that much and
    not by the length of the flood. Queued input is handled round robin, one piece per connection.

    Attributes:
        buffer: Buffer of the next read. All connections share it: a piece is copied before the next read.
    """

    # Bytes. A piece bounds the work that one read can cause: 1 kB holds 170 WebSocket frames, which take 1.5 ms.
    PIECE = 1024
    # Seconds. A stop takes several turns, each of which is longer by this during a flood.
    TURN = 0.002

    def __init__(self) -> None:
        self.buffer = memoryview(bytearray(self.PIECE))
        self._queue: deque[Work] = deque()
        self._spent = 0.0
        self._turn_planned = False

    @property
    def free(self) -> bool:
        """Whether work can run now: this turn has time left, and the queue is empty."""
        return self._spent < self.TURN and not self._queue

    def run(self, work: Work) -> None:
        """Run work now, and charge its time to this turn."""
        began = perf_counter()
        work()
        self.charge(perf_counter() - began)

    def enqueue(self, work: Work) -> None:
        """Queue work."""
        self._queue.append(work)
        self.charge(0.0)

    async def wait(self, cost: float) -> None:
        """Wait for a turn, and charge it with the seconds that the caller's work will cost."""
        granted = asyncio.get_running_loop().create_future()

        def grant() -> None:
            if not granted.done():
                self.charge(cost)
                granted.set_result(None)

        self.enqueue(grant)
        await granted

    async def sent(self, size: int) -> None:
        """Charge an output of this many bytes. If this turn is used up, wait for another one.

        Sending does not wait while the socket takes what is sent: a loop that sends would block all others.
        """
        self.charge(SEND_COST + size * BYTE_COST)
        if self._spent >= self.TURN:
            await self.wait(SEND_COST)

    def charge(self, seconds: float) -> None:
        """Charge time to this turn, including time that its work will cost elsewhere."""
        self._spent += seconds
        if not self._turn_planned:
            self._turn_planned = True
            asyncio.get_running_loop().call_soon(self._begin_turn)

    def _begin_turn(self) -> None:
        self._turn_planned = False
        self._spent = 0.0
        while self._queue and self._spent < self.TURN:
            self.run(self._queue.popleft())
