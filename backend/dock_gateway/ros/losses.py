"""Counts feedback that was not read on the listener's thread, and reports it on the loop at intervals."""

import asyncio
import threading
from collections import Counter
from collections.abc import Callable

from dock_gateway.ros.bridge import Bridge
from dock_gateway.ros.listener import Unread

# Seconds for which losses are counted before they are reported.
INTERVAL = 1.0
# The maximum number of counters (goal and cause) per interval; a node can make up any number of ids.
MAX_GOALS = 10

OnLoss = Callable[[str, Unread, int], None]


class Losses:
    """Counts losses by goal and cause.

    Args:
        bridge: The bridge to the loop.
        on_loss: Called on the loop with a goal id, why its messages were not read, and their number.
    """

    def __init__(self, bridge: Bridge, on_loss: OnLoss) -> None:
        self._bridge = bridge
        self._on_loss = on_loss
        self._lock = threading.Lock()
        self._counts: Counter[tuple[str, Unread]] = Counter()

    def count(self, goal_id: str, why: Unread) -> None:
        """Count a message of a goal that was not read; thread-safe."""
        with self._lock:
            if not self._counts:
                self._bridge.to_loop(self._report_soon)
            if len(self._counts) < MAX_GOALS or (goal_id, why) in self._counts:
                self._counts[goal_id, why] += 1

    def _report_soon(self) -> None:
        asyncio.get_running_loop().call_later(INTERVAL, self._report)

    def _report(self) -> None:
        with self._lock:
            counts, self._counts = self._counts, Counter()
        for (goal_id, why), count in counts.items():
            self._on_loss(goal_id, why, count)
