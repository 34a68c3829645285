"""Tickets: let a page of another origin open a WebSocket, for which a browser sends neither a header nor our cookie."""

import secrets
import time
from collections.abc import Callable

from dock_gateway.core.access import Principal
from dock_gateway.core.errors import NotAuthenticated

# Seconds that a ticket is valid.
LIFETIME = 30.0
# Maximum number of unused tickets; the oldest become invalid.
MAX_TICKETS = 1000


class Tickets:
    """Unused tickets. Each opens one WebSocket, at this gateway, for the user who asked for it.

    Args:
        clock: Returns seconds that never go back.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._unused: dict[str, tuple[Principal, float]] = {}  # oldest first

    def issue(self, principal: Principal) -> str:
        """Return a new ticket for a user."""
        ticket = secrets.token_urlsafe(32)
        self._unused[ticket] = principal, self._clock() + LIFETIME
        if len(self._unused) > MAX_TICKETS:
            del self._unused[next(iter(self._unused))]
        return ticket

    def redeem(self, ticket: str) -> Principal:
        """Return whose ticket it is. It is used up.

        Raises:
            NotAuthenticated: It is not known, was used or has expired (`invalid_ticket`).
        """
        principal, until = self._unused.pop(ticket, (None, 0.0))
        if principal is None or self._clock() >= until:
            raise NotAuthenticated("the ticket is not known, was used or has expired", code="invalid_ticket")
        return principal
