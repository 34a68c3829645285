"""Quotas of each user, so that a runaway script does not use up the gateway."""

import time
from collections import Counter, deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from dock_gateway.core.access import HUB, Principal
from dock_gateway.core.errors import TooManyRequests
from dock_gateway.settings import Settings

MINUTE = 60.0
# Names that many share, and the hub itself, which follows its site.
NOBODY = (None, HUB)


class Quotas:
    """Counts the goals, streams and exports of each user. There are no limits where a gateway or its hub asks nobody.

    A stop is never counted.

    Args:
        settings: The limits.
        clock: Returns seconds that never go back.
    """

    def __init__(self, settings: Settings, clock: Callable[[], float] = time.monotonic) -> None:
        self._goals_per_minute = settings.max_goals_per_minute
        self._most = {"streams": settings.max_streams_per_user, "exports": settings.max_exports_per_user}
        self._clock = clock
        self._sent: dict[str, deque[float]] = {}
        self._held: Counter[tuple[str, str]] = Counter()

    def spend_goal(self, principal: Principal) -> None:
        """Count a goal.

        Raises:
            TooManyRequests: The user has sent too many in the last minute (`too_many_goals`).
        """
        if principal.name in NOBODY:
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
    def hold(self, principal: Principal, what: str) -> Iterator[None]:
        """Count a stream or an export (`streams`, `exports`) while the block runs.

        Raises:
            TooManyRequests: The user has too many (`too_many_streams`, `too_many_exports`).
        """
        if principal.name in NOBODY:
            yield
            return
        key = principal.name, what
        if self._held[key] >= self._most[what]:
            raise TooManyRequests(f"{principal.name} already has {self._most[what]} {what}", code=f"too_many_{what}")
        self._held[key] += 1
        try:
            yield
        finally:
            self._held[key] -= 1
            if not self._held[key]:
                del self._held[key]
