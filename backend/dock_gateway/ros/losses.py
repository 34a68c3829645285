"""Feedback that was not read: counted on the listener's thread, told on the loop once in a while."""

import asyncio
import threading
from collections import Counter
from collections.abc import Callable

from dock_gateway.ros.bridge import Bridge
from dock_gateway.ros.listener import Unread

# Seconds in which losses are counted before they are told.
INTERVAL = 1.0
# Goals that losses are counted of one by one; a node can make up any number of ids.
MAX_GOALS = 10

OnLoss = Callable[[str, Unread, int], None]


class Losses:
    """Counts by goal and cause.

    Args:
        bridge: Where the loop is.
        on_loss: Called on the loop with the id of a goal, why its messages were not read, and how many.
    """

    def __init__(self, bridge: Bridge, on_loss: OnLoss) -> None:
        self._bridge = bridge
        self._on_loss = on_loss
        self._lock = threading.Lock()
        self._counts: Counter[tuple[str, Unread]] = Counter()

    def count(self, goal_id: str, why: Unread) -> None:
        """A message of a goal was not read; for any thread."""
        with self._lock:
            if not self._counts:
                self._bridge.to_loop(self._tell_soon)
            if len(self._counts) < MAX_GOALS or (goal_id, why) in self._counts:
                self._counts[goal_id, why] += 1

    def _tell_soon(self) -> None:
        asyncio.get_running_loop().call_later(INTERVAL, self._tell)

    def _tell(self) -> None:
        with self._lock:
            counts, self._counts = self._counts, Counter()
        for (goal_id, why), count in counts.items():
            self._on_loss(goal_id, why, count)
