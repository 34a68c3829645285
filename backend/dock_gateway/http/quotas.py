"""Quotas: each user has a share of what all users share, so that a runaway script does not use up the gateway.

`limits` lists everything that is shared. Lower layers take places by `core.request.slot` and `turn`.
"""

import asyncio
import math
import time
from collections import Counter, defaultdict, deque
from collections.abc import AsyncIterator, Callable, Hashable, Iterator, Mapping
from contextlib import asynccontextmanager, contextmanager
from dataclasses import dataclass, field

from dock_gateway.core.access import FORWARDER, Principal
from dock_gateway.core.errors import TooManyRequests
from dock_gateway.core.grant import Role
from dock_gateway.settings import Settings

MINUTE = 60.0


@dataclass(frozen=True)
class Limit:
    """The limit of something that users share.

    Attributes:
        noun: What it is called in errors.
        most: The number of places of all users together.
        share: Places of one user.
        reserve: Those of the places that are for users with the role `reserved_for` and above: others leave them free.
        code: Code of the error.
        reserved_for: The lowest role that may use the reserve.
        of_address: Places of one address, where no one logs in; default: all but the reserve.
    """

    noun: str
    most: float
    share: float
    reserve: int = 0
    code: str = TooManyRequests.code
    reserved_for: Role = Role.OPERATOR
    of_address: float | None = None

    def share_of(self, principal: Principal) -> float:
        """Return the number of places that a user may have."""
        if principal.name == FORWARDER:  # for many users, of whom it counts each
            return self.most
        if principal.name is not None:
            return self.share
        return self.most - self.reserve if self.of_address is None else self.of_address

    def open_to(self, principal: Principal) -> float:
        """Return the number of places that are not reserved for others."""
        return self.most if principal.grant.role.includes(self.reserved_for) else self.most - self.reserve


def limits(settings: Settings) -> dict[str, Limit]:
    """Return what users share of the gateway itself, by name: docs/configuration.md shows it.

    `streams` are WebSockets, event streams and subscriptions of `/ws`; `goals` are those of one action that wait for
    its server.
    """
    subscribers, pending, streams = settings.max_subscribers, settings.max_pending_goals, settings.max_streams_per_user
    return {
        "streams": Limit("streams", subscribers, streams, min(100, subscribers // 8), "too_many_streams"),
        "exports": Limit("exports", math.inf, settings.max_exports_per_user, code="too_many_exports"),
        "topics": Limit("topics subscribed to", 200, 75, 50),
        "views": Limit("topics being watched", 28, 8, 8),
        "goals": Limit("goals waiting for the answer of", pending, max(1, pending // 4), pending // 4),
        "approvals": Limit("goals waiting for a person", 10, 3, code="too_many_approvals", of_address=8),
        "calls": Limit("calls of services in progress", 32, 8, 8, "too_many_calls", Role.SUPERVISOR),
        "calls of one": Limit("calls in progress of", 8, 4, 2, "too_many_calls", Role.SUPERVISOR),
        "parameters": Limit("requests for parameters in progress", 8, 3, 2, "too_many_calls"),
        "large messages": Limit("large messages waiting to be read", 32, 8, 8),
        "logins": Limit("logins in progress", 100, 10, 10, "too_many_logins", of_address=20),
    }


NO_FURTHER: Mapping[str, Limit] = {}
# The number of long requests that a user may have in progress at the same time, by kind, where it is not one. Further
# ones wait; they are not refused.
TURNS = {"parameters of many": 2}


@dataclass
class _Places:
    """The places that are in use, by user and by what they are for. What several use takes one place of all."""

    own: dict[str, Counter[Hashable]] = field(default_factory=lambda: defaultdict(Counter))
    all: Counter[Hashable] = field(default_factory=Counter)

    def take(self, user: str, key: Hashable) -> None:
        self.own[user][key] += 1
        self.all[key] += 1

    def give(self, user: str, key: Hashable) -> None:
        for held in (self.own[user], self.all):
            held[key] -= 1
            if not held[key]:
                del held[key]
        if not self.own[user]:
            del self.own[user]


class Quotas:
    """Counts what each user has of what all users share, and their goals per minute.

    A user is who has logged in. Where no login is required, it is an address: it may have all but the reserve, which is
    left for the others. A stop is never counted.

    Args:
        settings: The limits.
        further: What users share of extensions, by name.
        clock: Returns seconds that never go back.
    """

    def __init__(
        self,
        settings: Settings,
        further: Mapping[str, Limit] = NO_FURTHER,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._goals_per_minute = settings.max_goals_per_minute
        self._limits = {**limits(settings), **further}
        self._clock = clock
        self._sent: dict[str, deque[float]] = {}
        self._places: dict[tuple[str, str], _Places] = {}
        self._turns: dict[tuple[str, str], tuple[asyncio.Semaphore, list[None]]] = {}

    def spend_goal(self, principal: Principal) -> None:
        """Count a goal. Where no login is required there is no limit.

        Raises:
            TooManyRequests: The user has sent too many in the last minute (`too_many_goals`).
        """
        if principal.name in (None, FORWARDER):
            return
        now = self._clock()
        self._forget(now)
        sent = self._sent.setdefault(principal.name, deque())
        if len(sent) >= self._goals_per_minute:
            detail = f"{principal.name} has sent {self._goals_per_minute} goals in the last minute"
            raise TooManyRequests(detail, code="too_many_goals")
        sent.append(now)

    def _forget(self, now: float) -> None:
        for name, sent in list(self._sent.items()):
            while sent and now - sent[0] >= MINUTE:
                sent.popleft()
            if not sent:
                del self._sent[name]

    @contextmanager
    def slot(self, principal: Principal, what: str, key: Hashable = None, per: str = "") -> Iterator[None]:
        """Take a place while the block runs.

        Args:
            principal: The user.
            what: What is shared, as `limits` names it.
            key: What the place is for, such as a topic: a user needs one place for it, and so do all together. Default:
                something of its own.
            per: What the limit is for, such as a service, where each of them has its own.

        Raises:
            TooManyRequests: The user has their share already, or all places are in use.
        """
        key = object() if key is None else key
        places, user = self._places.setdefault((what, per), _Places()), _user(principal)
        try:
            self._require_room(principal, what, key, per)
            places.take(user, key)
            try:
                yield
            finally:
                places.give(user, key)
        finally:
            if not places.all:
                self._places.pop((what, per), None)

    def _require_room(self, principal: Principal, what: str, key: Hashable, per: str) -> None:
        limit, places = self._limits[what], self._places[what, per]
        own = places.own.get(_user(principal), ())
        if key in own:
            return
        noun, most = f"{limit.noun} {per}".rstrip(), limit.open_to(principal)
        if len(own) >= limit.share_of(principal):
            kind = "address" if principal.name is None else "user"
            detail = f"{_described(principal)} {len(own)} {noun}: that is the share of one {kind}"
            raise TooManyRequests(detail, code=limit.code)
        if key not in places.all and len(places.all) >= most:
            reserved = f"; the other {limit.reserve} are reserved" if most < limit.most else ""
            detail = f"all users together have {len(places.all)} {noun}: that is the limit of all{reserved}"
            raise TooManyRequests(detail, code=limit.code)

    @asynccontextmanager
    async def turn(self, principal: Principal, what: str) -> AsyncIterator[None]:
        """Wait for a turn: of one user, one block runs at a time (or `TURNS[what]`), so that others need not queue."""
        key = what, _user(principal)
        semaphore, waiting = self._turns.setdefault(key, (asyncio.Semaphore(TURNS.get(what, 1)), []))
        waiting.append(None)
        try:
            async with semaphore:
                yield
        finally:
            waiting.pop()
            if not waiting:
                self._turns.pop(key, None)


def _user(principal: Principal) -> str:
    return principal.address if principal.name is None else principal.name


def _described(principal: Principal) -> str:
    if principal.name is None:
        return f"clients at {principal.address or 'this address'} already have"
    return f"{principal.name} already has"
