"""Goals that this process did not send: another client's, another gateway's, or ours from before a restart.

Nothing is published about such a goal before it is looked up in the history: it may be ours, and it may have ended long
ago. A ROS node that floods the graph with goals is throttled here, before it affects other users.
"""

import logging
from collections import OrderedDict, deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from dock_gateway.core.event import Now
from dock_gateway.core.goal import Goal
from dock_gateway.goals.limits import LIMITS, GoalLimits

log = logging.getLogger(__name__)

# Applies a message to its goal, once the goal is known.
Message = Callable[[Now, Goal], None]

# Goals adopted in one batch. All waiting goals are looked up together. Those that have ended are settled at once and do
# not count towards the batch.
BATCH = 50
# Goals that are adopted before a pause: a result is requested for each, and an action server queues only 10 requests
# (ROS's default).
REQUESTS_AT_ONCE = 5
# Seconds of that pause.
REQUEST_PAUSE = 0.02
# Maximum number of messages that wait with each goal that is looked up.
MAX_MESSAGES = 100


@dataclass
class Newcomer:
    """A goal that waits to be looked up.

    Attributes:
        created_ns: When it was accepted, if known, else when it was first seen; nanoseconds since 1970.
        since: When it was first seen, on the monotonic clock.
        running: Whether a message showed it as running.
        messages: The messages received, oldest first.
    """

    created_ns: int
    since: float
    running: bool = False
    messages: deque[Message] = field(default_factory=lambda: deque(maxlen=MAX_MESSAGES))


class Newcomers:
    """Unknown goals that wait to be looked up, running goals first. Pure, as `GoalMachine`."""

    def __init__(self, limits: GoalLimits = LIMITS) -> None:
        self._limits = limits
        self._waiting: OrderedDict[str, Newcomer] = OrderedDict()

    def __len__(self) -> int:
        return len(self._waiting)

    def __iter__(self) -> Iterator[str]:
        """Iterate over the ids of the goals to look up."""
        return iter(self._waiting)

    def __contains__(self, goal_id: object) -> bool:
        """Return whether a goal waits; thread-safe."""
        return goal_id in self._waiting

    def hear(self, goal_id: str, message: Message, *, created_ns: int, running: bool, now: float) -> None:
        """Take a message about a goal that is not tracked."""
        newcomer = self._waiting.get(goal_id)
        if newcomer is None:
            if len(self._waiting) >= self._limits.newcomers and not self._make_room(running=running):
                return
            newcomer = self._waiting[goal_id] = Newcomer(created_ns, now)
        newcomer.messages.append(message)
        if running and not newcomer.running:
            newcomer.running = True
            self._waiting.move_to_end(goal_id, last=False)

    def _make_room(self, *, running: bool) -> bool:
        """Drop an ended goal to make room for a running one. A running goal is reported again by its server."""
        limit = self._limits.newcomers
        log.warning("more than %d unknown goals were reported at the same time; some are ignored", limit)
        last = next(reversed(self._waiting))
        if not running or self._waiting[last].running:
            return False
        del self._waiting[last]
        return True

    def claim(self, goal_id: str) -> Newcomer | None:
        """Remove and return a goal that became known; None if it does not wait."""
        return self._waiting.pop(goal_id, None)

    def ready(self, asked: list[str], known: dict[str, Goal] | None, now: float) -> tuple[list[str], float]:
        """Return the goals to adopt now, and the seconds until the next lookup.

        Args:
            asked: The goals that were looked up, in their order.
            known: What the history knows about them, or None if it does not answer.
            now: Seconds on the monotonic clock.
        """
        if known is None:
            waiting = ((goal_id, self._waiting.get(goal_id)) for goal_id in asked)
            urgent = [
                goal_id for goal_id, it in waiting if it and it.running and now - it.since > self._limits.patience
            ]
            return urgent[:BATCH], self._limits.lookup_retry
        ended = [goal_id for goal_id in asked if goal_id in known and known[goal_id].status.final]
        others = [goal_id for goal_id in asked if goal_id not in known or not known[goal_id].status.final]
        return ended + others[:BATCH], self._limits.batch_interval if len(others) > BATCH else 0.0
