"""Connection limits: in total, per address, and a reserve that lets a stop through."""

import asyncio
import resource
from collections import Counter
from contextlib import suppress
from enum import IntEnum
from time import monotonic
from typing import Protocol

from dock_gateway.settings import Settings

RESERVE = 64
# File descriptors that are not for connections: DDS, the database, files.
OTHER_FILES = 128
# Seconds that a stop in the reserve may take to be answered.
STOP_TAKES = 2.0


class Priority(IntEnum):
    """The state of a connection. The reserve closes those of lower priority first."""

    IDLE = 0
    REQUEST = 1
    STOP = 2


class Limited(Protocol):
    """A connection, as the limits see it."""

    address: str

    @property
    def priority(self) -> Priority:
        """The priority of the client's request."""

    @property
    def stuck(self) -> bool:
        """Whether it is closing, and the client has read none of its pending output since the last check."""

    def abort(self) -> None:
        """Close it at once."""


class ConnectionLimits:
    """Counts and limits all connections.

    Without a free file descriptor no client can connect to stop a robot. Therefore fewer connections are accepted than
    the process could open, and the last of them are a reserve: a connection in the reserve may send one request, has no
    WebSocket, and is closed as soon as another one needs its place, unless a stop is being answered on it. Connections
    beyond the limit of their address are in the reserve, too.
    """

    def __init__(self, settings: Settings) -> None:
        self._limit = settings.max_connections
        self._per_address = settings.max_connections_per_address
        self._timeout = settings.subscriber_timeout
        self._regular: set[Limited] = set()
        self._addresses: Counter[str] = Counter()
        self._reserve: dict[Limited, float] = {}  # arrival times, oldest first
        self._check: asyncio.TimerHandle | None = None

    def __len__(self) -> int:
        return len(self._regular) + len(self._reserve)

    def admit(self, connection: Limited) -> bool:
        """Count a new connection.

        Returns:
            True for a regular connection. False if it is in the reserve, or closed already.
        """
        self._plan_check()
        files, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
        limit = max(8, min(self._limit, files - OTHER_FILES))
        reserve = min(RESERVE, limit // 4)
        if len(self._regular) < limit - reserve and self._addresses[connection.address] < self._per_address:
            self._regular.add(connection)
            self._addresses[connection.address] += 1
            return True
        now = monotonic()
        self._reserve[connection] = now
        if len(self._reserve) > reserve:
            others = [other for other in self._reserve if other is not connection]
            closed = min(others, key=lambda other: other.priority)  # the oldest one of the lowest priority
            if closed.priority is Priority.STOP and self._reserve[closed] > now - STOP_TAKES:
                closed = connection
            del self._reserve[closed]
            closed.abort()
        return False

    def release(self, connection: Limited) -> None:
        """Forget a connection that has ended."""
        self._reserve.pop(connection, None)
        if connection in self._regular:
            self._regular.remove(connection)
            self._addresses[connection.address] -= 1
            if not self._addresses[connection.address]:
                del self._addresses[connection.address]

    def _plan_check(self) -> None:
        if self._check is None:
            self._check = asyncio.get_running_loop().call_later(self._timeout, self._abort_stuck)

    def _abort_stuck(self) -> None:
        """Abort closing connections whose client does not read its pending output."""
        self._check = None
        for connection in [*self._regular, *self._reserve]:
            if connection.stuck:
                connection.abort()
        if len(self):
            self._plan_check()


def raise_file_limit() -> None:
    """Raise the process's limit of open files to the hard limit."""
    _, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    with suppress(ValueError, OSError):
        resource.setrlimit(resource.RLIMIT_NOFILE, (hard, hard))
