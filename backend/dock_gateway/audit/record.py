"""The record of requests and commands: an entry of each, for whoever listens."""

import asyncio
import uuid
from collections import Counter
from collections.abc import Awaitable, Callable
from dataclasses import dataclass

from dock_gateway.core.audit import AuditEntry
from dock_gateway.core.event import utc_now
from dock_gateway.core.listeners import Hooks, Listeners

# All clients without a valid login.
UNKNOWN = ""


@dataclass(frozen=True)
class RecordLimits:
    """Limits of the number of entries. Those beyond are only counted: they neither fill a disk nor displace others.

    Attributes:
        period: Seconds over which the limits apply.
        of_user: Maximum entries of one user in a period.
        unknown: Maximum entries of all clients without a valid login together in a period.
    """

    period: float = 60.0
    of_user: int = 600
    unknown: int = 30


RECORD_LIMITS = RecordLimits()


class RequestRecord:
    """Takes an entry of each request and command, without waiting, and passes it on.

    Args:
        limits: How much it takes.

    Attributes:
        on_entry: Called with each entry.
        until_stored: Each waits until an entry is stored; none if entries are not stored.
    """

    def __init__(self, limits: RecordLimits = RECORD_LIMITS) -> None:
        self._limits = limits
        self.on_entry = Listeners[[AuditEntry]]("an entry is recorded")
        self.until_stored = Hooks[Callable[[AuditEntry], Awaitable[None]]]()
        self._requests: Counter[str | None] = Counter()  # in this period, by user
        self._period: asyncio.TimerHandle | None = None

    def record(self, entry: AuditEntry) -> None:
        """Record an entry, or only count it; never waits, never raises."""
        user = UNKNOWN if entry.role is None else entry.principal
        self._requests[user] += 1
        if self._period is None:
            self._period = asyncio.get_running_loop().call_later(self._limits.period, self.end_period)
        if self._requests[user] <= self._most(user):
            self.on_entry(entry)

    async def store(self, entry: AuditEntry) -> None:
        """Record an entry, and wait until it is stored if entries are stored."""
        if entry.role is None:
            self.record(entry)
        else:
            self.on_entry(entry)
        for until_stored in self.until_stored:
            await until_stored(entry)

    def end_period(self) -> None:
        """Record how many requests of each user have no entry of their own."""
        if self._period is not None:
            self._period.cancel()
        self._period = None
        for user, count in self._requests.items():
            if (more := count - self._most(user)) > 0:
                unknown = user == UNKNOWN
                whose = "without a valid token" if unknown else f"of {user or 'users without a name'}"
                status, code = (401, "not_authenticated") if unknown else (429, "too_many_requests")
                self.on_entry(remark("more_requests", f"{more} more requests {whose}", status, code))
        self._requests.clear()

    def _most(self, user: str | None) -> int:
        return self._limits.unknown if user == UNKNOWN else self._limits.of_user


def remark(what: str, subject: str, status: int, code: str) -> AuditEntry:
    """Return an entry of the gateway itself."""
    no_request = dict.fromkeys(
        ("principal", "role", "token_id", "client", "request_id", "robot", "action_name", "goal_id"), None
    )
    return AuditEntry(uuid.uuid4().hex, utc_now(), what=what, subject=subject, status=status, code=code, **no_request)
