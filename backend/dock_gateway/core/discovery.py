"""What appears on the ROS graph is taken up one by one: neither one that fails nor a thousand keep out the others."""

import logging
import time
from collections.abc import Awaitable, Callable, Collection, Iterable
from dataclasses import dataclass

from dock_gateway.core.errors import GatewayError

log = logging.getLogger(__name__)

# Seconds that things are taken up in one go before the graph is looked at again.
TURN = 0.5
# One that failed is tried again after this many seconds.
RETRY_AFTER = 60.0

# What is wrong with a thing itself, and needs no traceback.
EXPECTED = (ImportError, TypeError, OverflowError)


@dataclass(frozen=True)
class Failure:
    """Why something cannot be used, and when it is tried again, on the monotonic clock."""

    why: str
    retry_at: float


class Discovery:
    """Takes up things of one kind.

    Args:
        kind: What the log calls them.
        limit: How many there may be.
        setting: What raises the limit.

    Attributes:
        failed: Those that are on the graph and cannot be used, by name.
    """

    def __init__(self, kind: str, limit: int, setting: str) -> None:
        self.failed: dict[str, Failure] = {}
        self._kind = kind
        self._limit = limit
        self._setting = setting

    async def take_up(
        self, names: Iterable[str], known: Collection[object], take_up: Callable[[str], Awaitable[object]]
    ) -> bool:
        """Take up what is new, for a moment.

        Args:
            names: Those on the graph that are not known yet.
            known: Those that are.
            take_up: Makes one known. What it raises is why it cannot be.

        Returns:
            Whether some are left.

        Raises:
            GatewayError: The ROS thread is down; it would be the same with the others.
        """
        until: float | None = None
        for name in names:
            now = time.monotonic()
            failure = self.failed.get(name)
            if failure is not None and now < failure.retry_at:
                continue
            if until is None:
                until = now + TURN
            elif now >= until:
                return True
            try:
                if len(known) >= self._limit:
                    raise OverflowError(f"there are {self._limit} already, see {self._setting}")
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
        self.failed[name] = Failure(why, time.monotonic() + RETRY_AFTER)
        if before is None or before.why != why:
            unexpected = not isinstance(error, EXPECTED)
            log.warning("%s %s is there and cannot be used: %s", self._kind, name, why, exc_info=unexpected)

    def keep(self, names: Collection[str]) -> None:
        """Forget the failures of all that is not on the graph any more."""
        self.failed = {name: failure for name, failure in self.failed.items() if name in names}
