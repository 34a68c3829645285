"""Messages that have no valid seal, and wait until it is verified who has sent them."""

import asyncio
import logging
import time
from collections import deque
from collections.abc import Callable

from dock_gateway.core.tasks import Tasks
from dock_gateway.sites.subscription import SiteMessage

log = logging.getLogger(__name__)

# Maximum number of messages that wait, and of their bytes.
MAX_WAITING, MAX_BYTES = 1000, 16 * 1024 * 1024
# Times as long as a message took: the pause before the next one, in which others work.
BREAK = 4.0


class Unsealed:
    """Opens messages one by one, in a fifth of the time, the newest first: the oldest are of no use any more.

    Args:
        serve: Opens one.
        drop: Called for one that is dropped, as too many wait.
    """

    def __init__(self, serve: Callable[[SiteMessage], None], drop: Callable[[SiteMessage], None]) -> None:
        self._serve = serve
        self._drop = drop
        self._waiting = deque[SiteMessage]()
        self._bytes = 0
        self._arrived = asyncio.Event()
        self._tasks = Tasks("opening messages without a seal")
        self._tasks.spawn(self._run())

    def put(self, received: SiteMessage) -> None:
        """Let a message wait."""
        self._waiting.append(received)
        self._bytes += len(received.data)
        while len(self._waiting) > MAX_WAITING or self._bytes > MAX_BYTES:
            oldest = self._waiting.popleft()
            self._bytes -= len(oldest.data)
            self._drop(oldest)
        self._arrived.set()

    async def close(self) -> None:
        """Open no more."""
        await self._tasks.close()

    async def _run(self) -> None:
        while True:
            await self._arrived.wait()
            while self._waiting:
                newest = self._waiting.pop()
                self._bytes -= len(newest.data)
                began = time.monotonic()
                try:
                    self._serve(newest)
                except Exception:  # the others are opened all the same
                    log.exception("while opening a message on %s that has no seal", newest.subject)
                await asyncio.sleep(BREAK * (time.monotonic() - began))
            self._arrived.clear()
