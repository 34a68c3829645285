"""The database interface of the history: transactions, each a plain function of a connection."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime
from typing import TypeVar, TypeVarTuple

import sqlalchemy as sa
import sqlalchemy.exc as sa_errors

from dock_gateway.storage.schema import create_tables

CONNECT_TIMEOUT = 2.0  # seconds
WRITE_TIMEOUT = 10.0  # seconds per transaction of goals and events
# Connections for writes (batches, new keys, ends of goals, audit) and for reads, so that none blocks another.
WRITERS, READERS = 4, 3

# The errors that a database may raise.
DATABASE_ERRORS = (sa_errors.SQLAlchemyError, OSError, TimeoutError, RuntimeError)

T = TypeVar("T")
Ts = TypeVarTuple("Ts")


@dataclass(frozen=True)
class Incident:
    """A loss of stored data: when it was noticed, what happened and what to do about it."""

    since: datetime
    detail: str


class Database(ABC):
    """A database. The functions passed to it may still run after the caller has given up, and must then do no harm.

    Attributes:
        prepared: Whether it is open and has its tables.
        incident: The last loss of its data, as long as it must be reported.
        lost: Whether its data is gone, because it is not the same database as before. The writer writes what is known
            again, and resets this.
        shared: Whether several gateways may use it.
        volatile: Whether it ends with the process. Then what waits to be written is as safe as what is written, and
            nothing has to wait for it.
    """

    shared = False
    volatile = False

    def __init__(self) -> None:
        self.prepared = False
        self.incident: Incident | None = None
        self.lost = False

    async def prepare(self) -> None:
        """Create the tables; several processes may do so at the same time."""
        if not self.prepared:
            await self.write(create_tables)
            self.prepared = True

    @abstractmethod
    async def write(self, work: Callable[[sa.Connection, *Ts], T], *args: *Ts, durable: bool = True) -> T:
        """Run a write transaction; one that is not `durable` may be lost in a power cut, never in a crash."""

    @abstractmethod
    async def read(self, work: Callable[[sa.Connection, *Ts], T], *args: *Ts) -> T:
        """Run a read transaction."""

    async def read_much(self, work: Callable[[sa.Connection, *Ts], T], *args: *Ts) -> T:
        """Run a read transaction that may take seconds."""
        return await self.read(work, *args)

    @abstractmethod
    async def close(self) -> None:
        """Close every connection."""


def is_about_data(error: Exception) -> bool:
    """Return whether the data itself was refused, so that a retry fails again: by the driver, or SQLSTATE 22 or 23."""
    if not isinstance(error, sa_errors.DBAPIError):
        return isinstance(error, sa_errors.StatementError | ValueError)
    if error.orig is not None and isinstance(error.orig.__cause__, ValueError):
        return True
    sqlstate = str(getattr(error.orig, "sqlstate", None) or "")
    return isinstance(error, sa_errors.DataError | sa_errors.IntegrityError) or sqlstate[:2] in ("22", "23")


def brief(error: Exception) -> str:
    """Return the error in one line, without the statement and its data."""
    cause = error.orig if isinstance(error, sa_errors.DBAPIError) and error.orig is not None else error
    unsaid = "no answer in time" if isinstance(cause, TimeoutError) else type(cause).__name__
    return (str(cause).strip() or unsaid).splitlines()[0][:300]


def display(url: str) -> str:
    """Return the URL of a database as it may be shown: without its password and further parameters."""
    return sa.make_url(url).set(query={}).render_as_string(hide_password=True) if "://" in url else url
