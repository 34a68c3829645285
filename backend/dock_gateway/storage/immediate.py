"""Writes that a request waits for: stored on return, or refused."""

import asyncio
import time
from collections.abc import Callable

import sqlalchemy as sa

from dock_gateway.core.errors import Unavailable
from dock_gateway.storage.database import DATABASE_ERRORS, Database, T, Ts
from dock_gateway.storage.reader import AWAY
from dock_gateway.storage.writer import Writer

# Seconds. A write that a loaded machine delays does not mean that the database is away.
WRITE_TIMEOUT = 3.0


class ImmediateWriter:
    """Writes to the database at once, without the queue and the spool of goals and events.

    Args:
        database: The database.
        writer: Is notified if it does not answer.
    """

    def __init__(self, database: Database, writer: Writer) -> None:
        self._database = database
        self._writer = writer

    async def write(self, work: Callable[[sa.Connection, *Ts], T], *args: *Ts, durable: bool = True) -> T:
        """Run a function of a connection in a transaction. What it raises is raised here, and nothing is stored.

        What is not `durable` may be lost in a power cut, never in a crash.

        Raises:
            Unavailable: The database does not answer (`history_unavailable`).
        """
        if not self._database.prepared:
            raise Unavailable(AWAY, code="history_unavailable")
        deadline = time.monotonic() + WRITE_TIMEOUT

        def write_in_time(connection: sa.Connection) -> T:
            if time.monotonic() > deadline:
                raise TimeoutError("the caller has given up")
            return work(connection, *args)

        try:
            async with asyncio.timeout(WRITE_TIMEOUT):
                return await self._database.write(write_in_time, durable=durable)
        except DATABASE_ERRORS as error:
            self._writer.doubt(error)
            raise Unavailable(AWAY, code="history_unavailable") from error
