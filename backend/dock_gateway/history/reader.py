"""Reads from the database in time, or says that it cannot be read."""

import asyncio
import time
from collections.abc import Callable

import sqlalchemy as sa

from dock_gateway.errors import Unavailable
from dock_gateway.history.database import Database, T, Ts
from dock_gateway.history.writer import DATABASE_ERRORS, Writer

READ_TIMEOUT = 1.0
# After a read that failed, the next ones fail at once for so long.
READ_PAUSE = 1.0


class Reader:
    """Reads from the database, as long as that answers."""

    def __init__(self, database: Database, writer: Writer) -> None:
        self._database = database
        self._writer = writer
        self._pause_until = 0.0

    async def read(self, work: Callable[[sa.Connection, *Ts], T], *args: *Ts, timeout: float = READ_TIMEOUT) -> T:
        """Carry out a function of a connection.

        Raises:
            Unavailable: The database does not answer (`history_unavailable`).
        """
        if not self._database.prepared or time.monotonic() < self._pause_until:
            raise Unavailable("the history database does not answer", code="history_unavailable")
        try:
            async with asyncio.timeout(timeout):
                return await self._database.read(work, *args)
        except DATABASE_ERRORS as error:
            self._pause_until = time.monotonic() + READ_PAUSE
            self._writer.doubt(error)
            raise Unavailable("the history database does not answer", code="history_unavailable") from error

    def require_everything(self) -> None:
        """See that there is nothing that is in the spool alone.

        Raises:
            Unavailable: There is (`history_unavailable`).
        """
        if self._writer.evicted:
            raise Unavailable("the history is catching up with its spool", code="history_unavailable")
