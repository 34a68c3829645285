"""How the event loop's time is shared between connections that send."""

import asyncio
from collections import deque
from collections.abc import Callable
from time import perf_counter

Work = Callable[[], None]


class InputScheduler:
    """Handles what connections receive: at once while there is time in this turn of the loop, else in turn.

    A turn of the loop spends at most `TURN` seconds on input, so that one client's flood delays the others by that much
    and not by the length of the flood. What has to wait is handled one piece a connection, round robin.

    Attributes:
        buffer: Where a connection's next piece is read to. All connections share it: it is copied before the next read.
    """

    # Bytes. A piece bounds the work that one read can cause: 1 kB holds 170 WebSocket frames, which take 1.5 ms.
    PIECE = 1024
    # Seconds. Several turns pass until a stop is answered, each of which is longer by this during a flood.
    TURN = 0.002

    def __init__(self) -> None:
        self.buffer = memoryview(bytearray(self.PIECE))
        self._queue: deque[Work] = deque()
        self._spent = 0.0
        self._turn_planned = False

    @property
    def free(self) -> bool:
        """Whether work can be done at once: there is time, and nobody else waits."""
        return self._spent < self.TURN and not self._queue

    def run(self, work: Work) -> None:
        """Do it now, and charge this turn with the time that it takes."""
        began = perf_counter()
        work()
        self.charge(perf_counter() - began)

    def enqueue(self, work: Work) -> None:
        """Have it done in turn."""
        self._queue.append(work)
        self.charge(0.0)

    def charge(self, seconds: float) -> None:
        """Count time that this turn costs, also what is going to be spent elsewhere because of it."""
        self._spent += seconds
        if not self._turn_planned:
            self._turn_planned = True
            asyncio.get_running_loop().call_soon(self._begin_turn)

    def _begin_turn(self) -> None:
        self._turn_planned = False
        self._spent = 0.0
        while self._queue and self._spent < self.TURN:
            self.run(self._queue.popleft())
