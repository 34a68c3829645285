"""The database that gateways share, and the spools of each: both outlive them."""

import asyncio
from collections.abc import AsyncIterator, Callable
from typing import Any, Protocol

import sqlalchemy as sa

from dock_gateway.storage.database import Database
from dock_gateway.storage.rows import entry_of, line_of
from dock_gateway.storage.schema import create_tables
from dock_gateway.storage.tables import BEGINNING, events, horizons, metadata, prepare_for
from tests.support.virtual import START_NS


class Disk:
    """The database that all gateways share: SQLite in memory, emptied for each run."""

    def __init__(self) -> None:
        prepare_for("sqlite")
        self.engine = sa.create_engine(
            "sqlite://", poolclass=sa.pool.StaticPool, connect_args={"check_same_thread": False}
        )
        with self.engine.begin() as connection:
            create_tables(connection)

    def empty(self) -> None:
        with self.engine.begin() as connection:
            for table in metadata.sorted_tables:
                if table.name in ("goals", "events", "idempotency_keys", "horizons", "documents"):
                    connection.execute(sa.delete(table))
            connection.execute(sa.insert(horizons).values(topic=BEGINNING, event_id=f"{START_NS:020d}"))

    def states(self) -> list[str]:
        """Return the ids of all stored states and results of goals, in order."""
        query = sa.select(events.c.id).where(events.c.topic == "goals", events.c.droppable.is_(sa.false()))
        with self.engine.begin() as connection:
            return list(connection.scalars(query.order_by(events.c.id)))


class Owner(Protocol):
    """The process that uses a database."""

    dead: bool


class SimulatedDatabase(Database):
    """The shared database as one gateway reaches it: each transaction happens at one moment, and takes its time."""

    def __init__(self, disk: Disk, owner: Owner, delay: Callable[[], float], *, shared: bool) -> None:
        super().__init__()
        self.shared = shared
        self.prepared = True
        self._disk = disk
        self._owner = owner
        self._delay = delay

    async def write(self, work: Callable[..., Any], *args: Any, durable: bool = True) -> Any:
        return await self.read(work, *args)

    async def read(self, work: Callable[..., Any], *args: Any) -> Any:
        await asyncio.sleep(self._delay())
        if self._owner.dead:
            raise OSError("killed")
        with self._disk.engine.begin() as connection:
            found = work(connection, *args)
        await asyncio.sleep(self._delay())
        return found

    async def close(self) -> None:
        pass


class SimulatedSpool:
    """The spool of one gateway, which outlives it; see `dock_gateway.storage.spool`."""

    lost = False

    def __init__(self, files: dict[int, list[bytes]]) -> None:
        self._files = files
        self._current: int | None = None

    @property
    def count(self) -> int:
        return sum(map(len, self._files.values()))

    async def take_over(self) -> list[int]:
        return list(self._files)

    async def read(self, files: list[int]) -> AsyncIterator[list[Any]]:
        for file in files:
            yield list(map(entry_of, self._files[file]))

    async def append(self, entries: list[Any]) -> None:
        if self._current is None:
            self._current = max(self._files, default=0) + 1
        self._files.setdefault(self._current, []).extend(map(line_of, entries))

    async def rotate(self) -> list[int]:
        self._current = None
        return list(self._files)

    async def remove(self, files: list[int]) -> None:
        for file in files:
            del self._files[file]

    async def close(self) -> None:
        pass
