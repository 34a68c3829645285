"""Reads from the database with a timeout."""

import asyncio
import time
from collections.abc import Callable

import sqlalchemy as sa

from dock_gateway.core.errors import Unavailable
from dock_gateway.core.request import turn
from dock_gateway.storage.database import DATABASE_ERRORS, Database, T, Ts
from dock_gateway.storage.writer import Writer

# Seconds. A read that a loaded machine delays does not mean that the database is away.
READ_TIMEOUT = 3.0
# Seconds after a failed read in which further reads fail at once.
READ_PAUSE = 1.0
MUCH_TIMEOUT = 8.0  # seconds, for large reads

AWAY = "the history database does not answer"
TOO_MUCH = f"the history query takes more than {MUCH_TIMEOUT:g} s; request less data"


class Reader:
    """Reads from the database; fails fast while it does not answer."""

    def __init__(self, database: Database, writer: Writer) -> None:
        self._database = database
        self._writer = writer
        self._pause_until = 0.0
        self._much = asyncio.Lock()

    async def read(self, work: Callable[[sa.Connection, *Ts], T], *args: *Ts, timeout: float | None = None) -> T:
        """Run a function of a connection. It may take `timeout` seconds, by default `READ_TIMEOUT`.

        Raises:
            Unavailable: The database does not answer (`history_unavailable`).
        """
        if not self._answers:
            raise Unavailable(AWAY, code="history_unavailable")
        try:
            async with asyncio.timeout(READ_TIMEOUT if timeout is None else timeout):
                return await self._database.read(work, *args)
        except DATABASE_ERRORS as error:
            raise self._away(error) from error

    async def read_much(self, work: Callable[[sa.Connection, *Ts], T], *args: *Ts) -> T:
        """Run a query that may take seconds; one at a time, so that other reads find a free connection.

        The queries of one user wait for one another first, so that those of the others have their turn.

        Raises:
            Unavailable: The database does not answer, or takes too long (`history_unavailable`).
        """
        async with turn("large reads"), self._much:
            if not self._answers:
                raise Unavailable(AWAY, code="history_unavailable")
            try:
                async with asyncio.timeout(MUCH_TIMEOUT) as deadline:
                    return await self._database.read_much(work, *args)
            except DATABASE_ERRORS as error:
                if deadline.expired():  # a slow query does not mean that the database is down
                    raise Unavailable(TOO_MUCH, code="history_unavailable") from error
                raise self._away(error) from error

    @property
    def _answers(self) -> bool:
        return self._database.prepared and time.monotonic() >= self._pause_until

    def _away(self, error: Exception) -> Unavailable:
        if self._writer.doubt(error):
            self._pause_until = time.monotonic() + READ_PAUSE
        return Unavailable(AWAY, code="history_unavailable")

    def require_everything(self) -> None:
        """Check that no entry is only in the spool.

        Raises:
            Unavailable: Some entries are (`history_unavailable`).
        """
        if self._writer.evicted:
            raise Unavailable("the history is catching up with its spool", code="history_unavailable")
