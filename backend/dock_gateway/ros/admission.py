"""Limits how many unknown goals a node can bring up.

A goal that this gateway does not know is looked up, stored and published, and its result is requested: some
milliseconds, a thousand times the cost of a message that is ignored. Each publisher has a limit of its own, so a node
that makes up goals does not keep the goals of others from being found.
"""

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol

from dock_gateway.ros.status import text_of

# The maximum number of goals of one publisher that are not ours, began in the last WINDOW seconds, and have not ended.
MAX_UNKNOWN, WINDOW = 50, 10.0
# The maximum number of publishers with a limit of their own. All others share one.
MAX_PUBLISHERS = 20
# Seconds between two checks whether goals of a publisher still count.
CHECK_INTERVAL = 0.1
# Seconds after the last ignored message until which the limit counts as exceeded.
RECENT = 30.0


class KnownGoals(Protocol):
    """The goals that the gateway knows. The methods are thread-safe."""

    def tracks(self, goal_id: str) -> bool:
        """Return whether a goal is tracked, or is being looked up."""
        ...

    def ended(self, goal_id: str) -> bool:
        """Return whether a goal ended for good."""
        ...


class _NoGoals:
    def tracks(self, _: str) -> bool:
        return False

    def ended(self, _: str) -> bool:
        return False


NO_GOALS: KnownGoals = _NoGoals()


@dataclass
class UnknownGoalPublisher:
    """A publisher of unknown goals.

    Attributes:
        since: When each of them was first seen, in seconds on the monotonic clock.
        checked_at: When goals that no longer count were last removed.
        reported: Whether it was reported to `on_excess`.
    """

    since: dict[bytes, float] = field(default_factory=dict)
    checked_at: float = float("-inf")
    reported: bool = False

    def is_idle(self, now: float) -> bool:
        """Return whether it has brought up no goal for a while."""
        return now - max(self.since.values(), default=float("-inf")) > WINDOW


class Admission:
    """Decides on ROS's threads which goals the loop gets to know.

    Args:
        goals: The goals that the gateway knows.
        on_excess: Called once with the `endpoint_gid` of each publisher that exceeds the limit.
        clock: Returns seconds.

    Attributes:
        ignored: Number of goals in status messages, and of feedback messages, that were ignored.
    """

    def __init__(
        self,
        goals: KnownGoals,
        on_excess: Callable[[bytes], None],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.ignored = 0
        self._goals = goals
        self._on_excess = on_excess
        self._clock = clock
        self._lock = threading.Lock()  # an action can be heard by two listeners
        self._publishers: dict[bytes, UnknownGoalPublisher] = {}
        self._others = UnknownGoalPublisher()
        self._ignored_at = float("-inf")

    @property
    def exceeded(self) -> bool:
        """Whether messages were ignored in the last `RECENT` seconds."""
        return self._clock() - self._ignored_at < RECENT

    def of_status(self, publisher: bytes, goal_id: bytes) -> bool:
        """Return whether to report a goal that a status message names."""
        text = text_of(goal_id)
        return self._goals.tracks(text) or self._goals.ended(text) or self._admits(publisher, goal_id)

    def of_feedback(self, publisher: bytes, goal_id: bytes) -> bool:
        """Return whether to read the feedback of a goal. That of a goal that has ended is of no use."""
        text = text_of(goal_id)
        return self._goals.tracks(text) or (not self._goals.ended(text) and self._admits(publisher, goal_id))

    def _admits(self, publisher: bytes, goal_id: bytes) -> bool:
        with self._lock:
            now = self._clock()
            found = self._find(publisher, now)
            if goal_id in found.since:
                return True
            if len(found.since) >= MAX_UNKNOWN and now - found.checked_at >= CHECK_INTERVAL:
                self._forget(found, now)
            if len(found.since) < MAX_UNKNOWN:
                found.since[goal_id] = now
                return True
            self.ignored += 1
            self._ignored_at = now
            reported, found.reported = found.reported, True
        if not reported:
            self._on_excess(publisher)
        return False

    def _find(self, gid: bytes, now: float) -> UnknownGoalPublisher:
        if gid not in self._publishers and len(self._publishers) >= MAX_PUBLISHERS:
            idle = next((gid for gid, each in self._publishers.items() if each.is_idle(now)), None)
            if idle is None:
                return self._others
            del self._publishers[idle]
        return self._publishers.setdefault(gid, UnknownGoalPublisher())

    def _forget(self, publisher: UnknownGoalPublisher, now: float) -> None:
        """Forget goals that no longer count: old ones, and those that have ended, as goals of real servers do."""
        publisher.checked_at = now
        publisher.since = {
            goal_id: since
            for goal_id, since in publisher.since.items()
            if now - since < WINDOW and not self._goals.ended(text_of(goal_id))
        }
