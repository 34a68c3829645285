"""SQLite. Each transaction runs as a whole on a thread.

Its statements are short; a return to the event loop after each would cost more than they do. There is one writer
thread: SQLite allows one writer at a time anyway, and two would poll for the lock.

The file may be deleted, replaced or damaged while it is open. SQLite does not notice the first two, and goes on writing
to an unlinked file. So each transaction checks that the file is still the one that was opened. If it is not, all
connections are closed and a new file is created.
"""

import asyncio
import logging
import sqlite3
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from datetime import UTC, datetime, timedelta
from functools import partial
from pathlib import Path
from typing import Any

import sqlalchemy as sa

from dock_gateway.storage.database import CONNECT_TIMEOUT, READERS, Database, Incident, T, Ts
from dock_gateway.storage.files import LOG_FILES, aside, beside, identity, is_damage, locked, set_aside
from dock_gateway.storage.schema import create_tables
from dock_gateway.storage.tables import prepare_for

log = logging.getLogger(__name__)

# Seconds that a statement waits for another process's lock before it fails, to be retried.
BUSY_TIMEOUT = 0.5
# The same while the tables are created and several processes may start at once.
LOCK_PATIENCE = 3.0
# How long a deleted or replaced file is reported. A damaged file that was renamed is reported until it has been moved.
TOLD_FOR = timedelta(hours=24)


class NotOpenError(OSError):
    """The opened file is gone or cannot be used; it will be reopened."""


class SqliteDatabase(Database):
    """A SQLite database in a file.

    Args:
        path: Path of the file, which is created with its folder.
    """

    def __init__(self, path: Path) -> None:
        super().__init__()
        prepare_for("sqlite")
        self._path = path
        self._files = tuple(beside(path, suffix) for suffix in ("", *LOG_FILES))
        # Identities: of the file that was last connected to, and of all files after they were opened successfully.
        self._connected: object = None
        self._opened: list[object] = []
        self._damage: str | None = None
        self._kept: Path | None = None  # where the file of the incident is kept
        self._writer = self._engine(1, write=True)
        self._reader = self._engine(READERS, write=False)
        self._write_thread = ThreadPoolExecutor(1, thread_name_prefix="history-write")
        self._read_threads = ThreadPoolExecutor(READERS, thread_name_prefix="history-read")
        self._running: set[Future[Any]] = set()

    # ------------------------------------------------------------------ transactions

    async def write(self, work: Callable[[sa.Connection, *Ts], T], *args: *Ts, durable: bool = True) -> T:
        """Run a write transaction; one that is not `durable` may be lost in a power cut, never in a crash."""

        def transaction() -> T:
            self._require_open()
            with self._begin(durable=durable) as connection:
                return work(connection, *args)

        return await self._run(self._write_thread, transaction)

    async def read(self, work: Callable[[sa.Connection, *Ts], T], *args: *Ts) -> T:
        """Run a read transaction."""

        def transaction() -> T:
            self._require_open()
            with self._watching(), self._reader.connect() as connection:
                return work(connection, *args)

        return await self._run(self._read_threads, transaction)

    async def _run(self, threads: ThreadPoolExecutor, transaction: Callable[[], T]) -> T:
        future = threads.submit(transaction)
        self._running.add(future)
        future.add_done_callback(self._running.discard)
        return await asyncio.wrap_future(future)

    async def close(self) -> None:
        """Close every connection after its last transaction; takes up to SQLite's lock timeout."""
        await self._all_done()
        await asyncio.wrap_future(self._write_thread.submit(self._disconnect))
        self._write_thread.shutdown(wait=False)
        self._read_threads.shutdown(wait=False)

    async def _all_done(self) -> None:
        running = [asyncio.wrap_future(future) for future in self._running.copy()]
        await asyncio.gather(*running, return_exceptions=True)

    def _disconnect(self) -> None:
        self._writer.dispose()
        self._reader.dispose()

    @contextmanager
    def _begin(self, *, durable: bool = True) -> Iterator[sa.Connection]:
        with (
            self._watching(),
            self._writer.connect() as connection,
            connection.execution_options(durable=durable).begin(),
        ):
            yield connection

    @contextmanager
    def _watching(self) -> Iterator[None]:
        """Detect SQLite errors that mean a damaged or read-only file."""
        try:
            yield
        except sa.exc.DBAPIError as error:
            if is_damage(error.orig):
                self._damage, self.prepared = str(error.orig), False
            elif _code(error) == sqlite3.SQLITE_READONLY:  # a new connection is needed once it is writable
                self.prepared = False
            raise

    def _require_open(self) -> None:
        """Check that the file is the one that was opened.

        Raises:
            NotOpenError: It is not, or it is not open.
        """
        if self.prepared and self._identities() != self._opened:
            self.prepared = False
        if not self.prepared:
            raise NotOpenError(f"{self._path} was replaced by another file and is opened again")
        if self.incident is not None and not self._is_told(self.incident):
            self.incident = None

    # ------------------------------------------------------------------ the file

    async def prepare(self) -> None:
        """Open the file, or a new one if it is gone or damaged, and create its tables.

        Several processes may do so at the same time.
        """
        if not self.prepared:
            await self._all_done()
            await self._run(self._write_thread, self._open)

    def _open(self) -> None:
        self._path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        self._make_way()
        self._disconnect()
        try:
            self._make_tables()
        except sa.exc.DBAPIError as error:
            if not is_damage(error.orig):
                raise
            self._make_way()
            self._disconnect()
            self._make_tables()
        except RuntimeError:  # the tables of another version; the file may be renamed meanwhile
            self._disconnect()
            raise
        self._opened = self._identities()
        if self._opened[0] != self._connected:
            raise NotOpenError(f"{self._path} was replaced while it was opened")
        self.prepared = True
        self._tell_of_earlier_damage()

    def _make_way(self) -> None:
        """If the file was damaged or replaced, move or delete its leftovers, so that a new file does not use them."""
        with locked(self._path.parent):
            found = self._identities()
            if self._damage is not None and found[0] == self._connected:
                self._kept = set_aside(self._path)
                self._lose(
                    f"{self._path} was damaged ({self._damage}). It is kept as {self._kept}, and a new history was "
                    "started. Check the disk; move the damaged file to clear this alert."
                )
            elif self._opened and found[0] != self._opened[0]:
                for path, opened, there in zip(self._files[1:], self._opened[1:], found[1:], strict=True):
                    if there is not None and there == opened:
                        path.unlink()  # SQLite would apply it to the new file
                what = "deleted" if found[0] is None else "replaced by another file"
                self._kept = None
                self._lose(f"{self._path} was {what} while the gateway was running. Its contents are lost.")
            self._damage, self._opened = None, []

    def _lose(self, detail: str) -> None:
        log.error("%s", detail)
        self.incident = Incident(datetime.now(UTC), detail)
        self.lost = True

    def _tell_of_earlier_damage(self) -> None:
        if self.incident is None and (found := aside(self._path)):
            since = max(found)
            self._kept = found[since]
            self.incident = Incident(
                since,
                f"{self._path} was damaged and is kept as {self._kept}. Check the disk; move the damaged file to "
                "clear this alert.",
            )
            log.warning("%s", self.incident.detail)

    def _is_told(self, incident: Incident) -> bool:
        if self._kept is not None:
            return self._kept.exists()
        return datetime.now(UTC) - incident.since < TOLD_FOR

    def _make_tables(self) -> None:
        deadline = time.monotonic() + LOCK_PATIENCE
        while True:
            try:
                with self._begin() as connection:
                    create_tables(connection)
            except sa.exc.OperationalError as error:
                # SQLite does not wait for a process that is creating the file; so wait here.
                if _code(error) != sqlite3.SQLITE_BUSY or time.monotonic() > deadline:
                    raise
                time.sleep(0.05)
            else:
                return

    def _identities(self) -> list[object]:
        return [identity(path) for path in self._files]

    def _connect(self, *, write: bool) -> sqlite3.Connection:
        with locked(self._path.parent):
            before = identity(self._path)
            connection = sqlite3.connect(
                self._path,
                timeout=BUSY_TIMEOUT,
                isolation_level=None,  # the driver must not begin transactions itself
                check_same_thread=False,  # used by one thread at a time
            )
            try:
                self._connected = identity(self._path)
                if self._connected != (before or self._connected) or (self._opened and before != self._opened[0]):
                    raise NotOpenError(f"{self._path} was replaced while it was opened")
                connection.execute("PRAGMA journal_mode=WAL")
                connection.execute("PRAGMA synchronous=FULL")
                if not write:
                    connection.execute("PRAGMA query_only=ON")
            except BaseException:
                connection.close()
                raise
        return connection

    def _engine(self, connections: int, *, write: bool) -> sa.Engine:
        engine = sa.create_engine(
            "sqlite://",
            creator=partial(self._connect, write=write),
            poolclass=sa.pool.QueuePool,
            pool_size=connections,
            max_overflow=0,
            pool_timeout=CONNECT_TIMEOUT,
        )

        @sa.event.listens_for(engine, "begin")
        def began(connection: sa.Connection) -> None:
            if write:
                durable = connection.get_execution_options().get("durable", True)
                connection.exec_driver_sql(f"PRAGMA synchronous={'FULL' if durable else 'NORMAL'}")
            # A write transaction takes the lock first: after a read it might not be able to take it.
            connection.exec_driver_sql("BEGIN IMMEDIATE" if write else "BEGIN")

        return engine


def _code(error: sa.exc.DBAPIError) -> int:
    """Return the primary SQLite error code."""
    return getattr(error.orig, "sqlite_errorcode", 0) & 0xFF
