"""SQLite in memory (`memory:`). Nothing outlives the process."""

import asyncio
import sqlite3
from collections.abc import Callable

import sqlalchemy as sa

from dock_gateway.storage.database import Database, T, Ts
from dock_gateway.storage.schema import create_tables
from dock_gateway.storage.tables import prepare_for


class MemoryDatabase(Database):
    """One connection. Short transactions run on the event loop: they wait for no disk, and a thread would cost more."""

    volatile = True

    def __init__(self) -> None:
        super().__init__()
        prepare_for("sqlite")
        # A loop may use what another thread has opened, never two at a time.
        engine = sa.create_engine("sqlite://", poolclass=sa.pool.StaticPool, connect_args={"check_same_thread": False})
        self._connection = engine.connect()
        with self._connection.begin():
            create_tables(self._connection)
        self.prepared = True

    async def write(self, work: Callable[[sa.Connection, *Ts], T], *args: *Ts, durable: bool = True) -> T:
        """Run a write transaction."""
        return await self.read(work, *args)

    async def read(self, work: Callable[[sa.Connection, *Ts], T], *args: *Ts) -> T:
        """Run a transaction."""
        with self._connection.begin():
            return work(self._connection, *args)

    async def read_much(self, work: Callable[[sa.Connection, *Ts], T], *args: *Ts) -> T:
        """Run a read transaction on a copy, in a thread, so that it does not hold up the event loop."""
        driver_connection = self._connection.connection.driver_connection
        assert isinstance(driver_connection, sqlite3.Connection)
        return await asyncio.to_thread(_read_copy, driver_connection.serialize(), lambda copy: work(copy, *args))

    async def close(self) -> None:
        """Forget everything."""
        self._connection.close()
        self._connection.engine.dispose()


def _read_copy(copy: bytes, work: Callable[[sa.Connection], T]) -> T:
    def connect() -> sqlite3.Connection:
        connection = sqlite3.connect(":memory:")
        connection.deserialize(copy)
        return connection

    engine = sa.create_engine("sqlite://", creator=connect, poolclass=sa.pool.StaticPool)
    try:
        with engine.connect() as connection:
            return work(connection)
    finally:
        engine.dispose()
