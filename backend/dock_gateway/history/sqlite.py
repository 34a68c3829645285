"""SQLite. A transaction is one piece of work for a thread.

Its statements are short, and to come back to the event loop after each would cost more than they do.
"""

import asyncio
import time
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import sqlalchemy as sa
from sqlalchemy.engine.interfaces import DBAPIConnection

from dock_gateway.history.database import CONNECT_TIMEOUT, READERS, WRITERS, Database, T, Ts
from dock_gateway.history.tables import prepare_for

# How long another process may hold the lock before a statement fails, to be tried again
BUSY_MS = 500
# and for the tables to be made, when several start at the same time
LOCK_PATIENCE = 1.5


class SqliteDatabase(Database):
    """A file.

    Args:
        path: Of the file; it is made, with its folder.
    """

    def __init__(self, path: Path) -> None:
        super().__init__()
        prepare_for("sqlite")
        self._path = path
        self._writer = _engine(path, WRITERS, write=True)
        self._reader = _engine(path, READERS, write=False)
        self._write_threads = ThreadPoolExecutor(WRITERS, thread_name_prefix="history-write")
        self._read_threads = ThreadPoolExecutor(READERS, thread_name_prefix="history-read")
        self._running: set[Future[Any]] = set()

    async def prepare(self) -> None:
        """Make the tables, or bring them up to date; several processes may do so at the same time."""
        self._path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        deadline = time.monotonic() + LOCK_PATIENCE
        while not self.prepared:
            try:
                await super().prepare()
            except sa.exc.OperationalError as error:
                # SQLite does not wait for another process that is making the file; so this one does.
                if "locked" not in str(error.orig) or time.monotonic() > deadline:
                    raise
                await asyncio.sleep(0.05)

    async def write(self, work: Callable[[sa.Connection, *Ts], T], *args: *Ts, durable: bool = True) -> T:
        """A transaction that writes; one that is not `durable` may be lost in a power cut, never in a crash."""

        def transaction() -> T:
            with self._writer.connect() as connection, connection.execution_options(durable=durable).begin():
                return work(connection, *args)

        return await self._run(self._write_threads, transaction)

    async def read(self, work: Callable[[sa.Connection, *Ts], T], *args: *Ts) -> T:
        """A transaction that reads."""

        def transaction() -> T:
            with self._reader.connect() as connection:
                return work(connection, *args)

        return await self._run(self._read_threads, transaction)

    async def _run(self, threads: ThreadPoolExecutor, transaction: Callable[[], T]) -> T:
        future = threads.submit(transaction)
        self._running.add(future)
        future.add_done_callback(self._running.discard)
        return await asyncio.wrap_future(future)

    async def close(self) -> None:
        """Close every connection, once nobody uses it any more: that takes as long as SQLite waits for a lock."""
        running = [asyncio.wrap_future(future) for future in self._running.copy()]
        await asyncio.gather(*running, return_exceptions=True)
        await asyncio.wrap_future(self._write_threads.submit(self._dispose))
        self._write_threads.shutdown(wait=False)
        self._read_threads.shutdown(wait=False)

    def _dispose(self) -> None:
        self._writer.dispose()
        self._reader.dispose()


def _engine(path: Path, connections: int, *, write: bool) -> sa.Engine:
    engine = sa.create_engine(
        sa.URL.create("sqlite", database=str(path)),
        pool_size=connections,
        max_overflow=0,
        pool_timeout=CONNECT_TIMEOUT,
        poolclass=sa.pool.QueuePool,
        connect_args={"check_same_thread": False},  # a thread after the other, never two at the same time
    )

    @sa.event.listens_for(engine, "connect")
    def connected(connection: DBAPIConnection, _: object) -> None:
        connection.isolation_level = None  # the driver must not begin transactions on its own
        cursor = connection.cursor()
        cursor.execute(f"PRAGMA busy_timeout={BUSY_MS}")
        cursor.execute("PRAGMA journal_mode=WAL")
        cursor.execute("PRAGMA synchronous=FULL")
        if not write:
            cursor.execute("PRAGMA query_only=ON")
        cursor.close()

    @sa.event.listens_for(engine, "begin")
    def began(connection: sa.Connection) -> None:
        if write:
            durable = connection.get_execution_options().get("durable", True)
            connection.exec_driver_sql(f"PRAGMA synchronous={'FULL' if durable else 'NORMAL'}")
        # A transaction that writes takes the lock first: one that had only read could not take it any more.
        connection.exec_driver_sql("BEGIN IMMEDIATE" if write else "BEGIN")

    return engine
