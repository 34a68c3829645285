"""Tickets: let a page of another origin open a WebSocket, for which a browser sends neither a header nor our cookie."""

import secrets
import time
from collections.abc import Callable

from dock_gateway.core.access import Principal
from dock_gateway.core.errors import NotAuthenticated

# Seconds that a ticket is valid.
LIFETIME = 30.0
# Maximum number of unused tickets of one user; their oldest become invalid, not those of others.
MAX_TICKETS = 100


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
        now = self._clock()
        self._unused = {ticket: held for ticket, held in self._unused.items() if held[1] > now}
        own = [
            ticket
            for ticket, (user, _) in self._unused.items()
            if (user.name, user.kind) == (principal.name, principal.kind)
        ]
        for oldest in own[: max(0, len(own) + 1 - MAX_TICKETS)]:
            del self._unused[oldest]
        ticket = secrets.token_urlsafe(32)
        self._unused[ticket] = principal, now + LIFETIME
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
