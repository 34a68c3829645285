"""One transaction for all that wait for one: what comes while it runs goes into the next."""

import asyncio
import logging
from collections.abc import Awaitable, Callable
from typing import Generic, TypeVar

from dock_gateway.storage.database import DATABASE_ERRORS
from dock_gateway.storage.rows import Batch

log = logging.getLogger(__name__)

ResultT = TypeVar("ResultT")


class GroupCommit(Generic[ResultT]):
    """Stores what somebody waits for, at once, one transaction after the other.

    Args:
        store: Stores a batch in a transaction.
    """

    def __init__(self, store: Callable[[Batch], Awaitable[ResultT]]) -> None:
        self._store = store
        self._pending: list[tuple[Batch, asyncio.Future[ResultT]]] = []
        self._wake = asyncio.Event()

    def commit(self, batch: Batch) -> "asyncio.Future[ResultT]":
        """Store a batch with the next transaction; return what `store` will return or raise for that.

        Cancel it to give up: what no transaction has begun to store then is left out.
        """
        future: asyncio.Future[ResultT] = asyncio.get_running_loop().create_future()
        self._pending.append((batch, future))
        self._wake.set()
        return future

    def wake(self) -> None:
        """Run a transaction soon, though nothing may be pending."""
        self._wake.set()

    async def run(self) -> None:
        """Store what is pending, until it is canceled."""
        while True:
            await self._wake.wait()
            self._wake.clear()
            taken = [(batch, future) for batch, future in self._pending if not future.cancelled()]
            self._pending = []
            try:
                stored = await self._store(Batch.joined(batch for batch, _ in taken))
            except Exception as error:
                if not isinstance(error, DATABASE_ERRORS):
                    log.exception("while storing")
                for _, future in taken:
                    if not future.done():
                        future.set_exception(error)
            else:
                for _, future in taken:
                    if not future.done():
                        future.set_result(stored)
