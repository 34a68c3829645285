"""What a database is to the history: transactions, each a plain function of a connection."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import TypeVar, TypeVarTuple

import sqlalchemy as sa

from dock_gateway.history.migrate import migrate
from dock_gateway.history.protocol import Incident

CONNECT_TIMEOUT = 2.0
# A few connections to write (what waits, new keys, ends of goals) and a few to read, so that none waits for another.
WRITERS, READERS = 3, 3

T = TypeVar("T")
Ts = TypeVarTuple("Ts")


class Database(ABC):
    """A database. The functions it is given must do no harm when they are carried out after all, when nobody waits.

    Attributes:
        prepared: Whether it is open, and its tables are up to date.
        incident: What happened to what was in it, as long as somebody has to know of that.
        lost: Whether it is another one than before: what was in it is missing. Whoever knows some of it writes it
            again, and sets this to False.
        shared: Whether it is made to be used by several gateways.
    """

    shared = False

    def __init__(self) -> None:
        self.prepared = False
        self.incident: Incident | None = None
        self.lost = False

    async def prepare(self) -> None:
        """Make the tables, or bring them up to date; several processes may do so at the same time."""
        if not self.prepared:
            await self.write(migrate)
            self.prepared = True

    @abstractmethod
    async def write(self, work: Callable[[sa.Connection, *Ts], T], *args: *Ts, durable: bool = True) -> T:
        """A transaction that writes; one that is not `durable` may be lost in a power cut, never in a crash."""

    @abstractmethod
    async def read(self, work: Callable[[sa.Connection, *Ts], T], *args: *Ts) -> T:
        """A transaction that reads."""

    @abstractmethod
    async def close(self) -> None:
        """Close every connection."""
