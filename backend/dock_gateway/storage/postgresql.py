"""PostgreSQL through asyncpg."""

from collections.abc import Callable
from typing import Any

import asyncpg
import sqlalchemy as sa
from sqlalchemy.ext.asyncio import AsyncEngine, create_async_engine

from dock_gateway.storage.database import CONNECT_TIMEOUT, READERS, WRITERS, Database, T, Ts
from dock_gateway.storage.tables import prepare_for

STATEMENT_TIMEOUT = 10.0  # seconds


class PostgresqlDatabase(Database):
    """A PostgreSQL database.

    Args:
        url: `postgresql://…`, in the form that asyncpg accepts.
    """

    shared = True

    def __init__(self, url: str) -> None:
        super().__init__()
        prepare_for("postgresql")
        self._url = url
        self._writer = self._engine(WRITERS)
        self._reader = self._engine(READERS)

    def _engine(self, connections: int) -> AsyncEngine:
        return create_async_engine(
            "postgresql+asyncpg://",
            async_creator=self._connect,
            pool_size=connections,
            max_overflow=0,
            pool_timeout=CONNECT_TIMEOUT,
            pool_pre_ping=True,
        )

    async def _connect(self) -> Any:
        limit = f"{STATEMENT_TIMEOUT * 1000:.0f}"
        try:
            return await asyncpg.connect(
                self._url,
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
        except TimeoutError as error:
            raise TimeoutError(f"no connection within {CONNECT_TIMEOUT:g} s") from error

    async def write(self, work: Callable[[sa.Connection, *Ts], T], *args: *Ts, durable: bool = True) -> T:
        """Run a write transaction; one that is not `durable` may be lost when the server loses power."""
        async with self._writer.begin() as connection:
            if not durable:
                await connection.execute(sa.text("SET LOCAL synchronous_commit TO off"))
            return await connection.run_sync(work, *args)

    async def read(self, work: Callable[[sa.Connection, *Ts], T], *args: *Ts) -> T:
        """Run a read transaction."""
        async with self._reader.connect() as connection:
            return await connection.run_sync(work, *args)

    async def close(self) -> None:
        """Close every connection."""
        await self._writer.dispose()
        await self._reader.dispose()
