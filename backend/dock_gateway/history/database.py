"""The connections to SQLite or PostgreSQL, and transactions on them."""

import asyncio
import logging
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import sqlalchemy as sa
from sqlalchemy.engine.interfaces import DBAPIConnection
from sqlalchemy.ext.asyncio import AsyncConnection, AsyncEngine, create_async_engine

from dock_gateway.history.migrate import migrate

log = logging.getLogger(__name__)

CONNECT_TIMEOUT = 2.0
STATEMENT_TIMEOUT = 10.0
# SQLite: how long another process may hold the lock before a statement fails, to be tried again
BUSY_MS = 500
# and for the tables to be made, when several start at the same time
LOCK_PATIENCE = 1.5


class Database:
    """One database: a few connections to write and a few to read, so that neither waits for the other."""

    def __init__(self, url: str) -> None:
        self.url = url
        self._path = Path(url.removeprefix("sqlite:///")) if url.startswith("sqlite:///") else None
        self._writer = self._engine(write=True)
        self._reader = self._engine(write=False)
        self.prepared = False

    def _engine(self, *, write: bool) -> AsyncEngine:
        size = 2 if write else 3
        if self._path is not None:
            engine = create_async_engine(
                sa.URL.create("sqlite+aiosqlite", database=str(self._path)),
                pool_size=size,
                max_overflow=0,
                pool_timeout=CONNECT_TIMEOUT,
                poolclass=sa.pool.AsyncAdaptedQueuePool,
            )
            _tune_sqlite(engine, write=write)
            return engine
        return create_async_engine(
            "postgresql+asyncpg://",
            async_creator=self._connect_postgresql,
            pool_size=size,
            max_overflow=0,
            pool_timeout=CONNECT_TIMEOUT,
            pool_pre_ping=True,
        )

    async def _connect_postgresql(self) -> Any:
        import asyncpg  # noqa: PLC0415 - whoever uses SQLite need not load it

        limit = f"{STATEMENT_TIMEOUT * 1000:.0f}"
        try:
            return await asyncpg.connect(
                self.url,
                timeout=CONNECT_TIMEOUT,
                command_timeout=STATEMENT_TIMEOUT,
                server_settings={
                    "application_name": "dock-gateway",
                    "statement_timeout": limit,
                    "idle_in_transaction_session_timeout": limit,
                },
            )
        except (asyncpg.PostgresError, asyncpg.InterfaceError, ValueError) as error:
            raise ConnectionError(str(error)) from error

    async def prepare(self) -> None:
        """Make the tables, or bring them up to date; several processes may do so at the same time."""
        if self._path is not None:
            self._path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        deadline = time.monotonic() + LOCK_PATIENCE
        while not self.prepared:
            try:
                await migrate(self._writer)
                self.prepared = True
            except sa.exc.OperationalError as error:
                # SQLite does not wait for another process that is making the file; so this one does.
                if "locked" not in str(error.orig) or time.monotonic() > deadline:
                    raise
                await asyncio.sleep(0.05)

    @asynccontextmanager
    async def write(self, *, durable: bool = True) -> AsyncIterator[AsyncConnection]:
        """A transaction that writes; one that is not `durable` may be lost in a power cut, never in a crash."""
        async with self._writer.connect() as connection:
            await connection.execution_options(durable=durable)
            async with connection.begin():
                yield connection

    @asynccontextmanager
    async def read(self) -> AsyncIterator[AsyncConnection]:
        """A transaction that reads."""
        async with self._reader.connect() as connection:
            yield connection

    async def close(self) -> None:
        """Close every connection."""
        await self._writer.dispose()
        await self._reader.dispose()


def _tune_sqlite(engine: AsyncEngine, *, write: bool) -> None:
    @sa.event.listens_for(engine.sync_engine, "connect")
    def connected(connection: DBAPIConnection, _: object) -> None:
        connection.isolation_level = None  # the driver must not begin transactions on its own
        cursor = connection.cursor()
        cursor.execute(f"PRAGMA busy_timeout={BUSY_MS}")
        cursor.execute("PRAGMA journal_mode=WAL")
        cursor.execute("PRAGMA synchronous=FULL")
        if not write:
            cursor.execute("PRAGMA query_only=ON")
        cursor.close()

    @sa.event.listens_for(engine.sync_engine, "begin")
    def began(connection: sa.Connection) -> None:
        if write:
            durable = connection.get_execution_options().get("durable", True)
            connection.exec_driver_sql(f"PRAGMA synchronous={'FULL' if durable else 'NORMAL'}")
        # A transaction that writes takes the lock first: one that had only read could not take it any more.
        connection.exec_driver_sql("BEGIN IMMEDIATE" if write else "BEGIN")
