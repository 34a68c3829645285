"""Registers what appears on the ROS graph, one by one: neither a failure nor a flood of names blocks the others."""

import logging
import time
from collections.abc import Awaitable, Callable, Collection, Iterable
from dataclasses import dataclass

from dock_gateway.core.errors import GatewayError

log = logging.getLogger(__name__)

# Errors caused by the thing itself; they are logged without a traceback.
EXPECTED = (ImportError, TypeError, OverflowError)


@dataclass(frozen=True)
class Failure:
    """The reason why something cannot be used, and the time of the next attempt, on the monotonic clock."""

    why: str
    retry_at: float


class Discovery:
    """Registers things of one kind.

    Args:
        kind: Their name in the log.
        limit: Maximum number of them.
        setting: Name of the setting that raises the limit.
        turn: Seconds that one call of `take_up` may run before the graph is scanned again.
        retry_after: Seconds before one that cannot be used is retried.
        retry_soon: The same for one that failed for another reason: ROS may still be letting go of what had its name.

    Attributes:
        failed: Those on the graph that cannot be used, by name.
    """

    def __init__(
        self,
        kind: str,
        limit: int,
        setting: str,
        *,
        turn: float = 0.5,
        retry_after: float = 60.0,
        retry_soon: float = 5.0,
    ) -> None:
        self.failed: dict[str, Failure] = {}
        self._kind = kind
        self._limit = limit
        self._setting = setting
        self._turn = turn
        self._retry_after = retry_after
        self._retry_soon = retry_soon

    async def take_up(
        self, names: Iterable[str], known: Collection[object], take_up: Callable[[str], Awaitable[object]]
    ) -> bool:
        """Register new names, for at most one turn.

        Args:
            names: Names on the graph that are not registered yet.
            known: What is already registered.
            take_up: Registers one. An exception means that it cannot be used, and says why.

        Returns:
            Whether some names are left.

        Raises:
            GatewayError: The ROS thread is down, so the others would fail too.
        """
        until: float | None = None
        for name in names:
            now = time.monotonic()
            failure = self.failed.get(name)
            if failure is not None and now < failure.retry_at:
                continue
            if until is None:
                until = now + self._turn
            elif now >= until:
                return True
            try:
                if len(known) >= self._limit:
                    raise OverflowError(f"the limit of {self._limit} is reached, see {self._setting}")
                await take_up(name)
            except GatewayError:
                raise
            except Exception as error:  # noqa: BLE001 - whatever others put on the graph
                self._note(name, error)
            else:
                self.failed.pop(name, None)
        return False

    def _note(self, name: str, error: Exception) -> None:
        before, why = self.failed.get(name), str(error) or repr(error)
        unexpected = not isinstance(error, EXPECTED)
        self.failed[name] = Failure(why, time.monotonic() + (self._retry_soon if unexpected else self._retry_after))
        if before is None or before.why != why:
            log.warning("%s %s is on the ROS graph but cannot be used: %s", self._kind, name, why, exc_info=unexpected)

    def keep(self, names: Collection[str]) -> None:
        """Forget the failures of names that are no longer on the graph."""
        self.failed = {name: failure for name, failure in self.failed.items() if name in names}
