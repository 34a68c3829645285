"""Goals that this process did not send: another client's, another gateway's, or ours from before a restart.

Nothing is published about such a goal before it is looked up in the history: it may be ours, and it may have ended long
ago. A ROS node that floods the graph with goals is throttled here, before it affects other users.
"""

import asyncio
import logging
import time
from collections import OrderedDict, deque
from collections.abc import Callable
from dataclasses import dataclass, field

from dock_gateway.core.errors import GatewayError
from dock_gateway.core.goal import Goal
from dock_gateway.core.tasks import Tasks
from dock_gateway.history import History

log = logging.getLogger(__name__)

# Applies a message to its goal, once the goal is known.
Message = Callable[[Goal], None]

# Goals adopted in one batch, and seconds between two batches: 100 goals/s. All waiting goals are looked up together.
# Those that have ended are settled at once and do not count towards the batch.
BATCH, BATCH_INTERVAL = 50, 0.5
# Maximum number of goals that wait to be looked up, and of messages that wait with each.
MAX_NEWCOMERS, MAX_MESSAGES = 1000, 100
# Seconds that a running goal is held back while the history does not answer, and seconds between two lookups then.
PATIENCE = 0.5
RETRY_INTERVAL = 0.1


@dataclass
class Newcomer:
    """A goal that waits to be looked up.

    Attributes:
        created_ns: When it was accepted, if known, else when it was first seen; nanoseconds since 1970.
        running: Whether a message showed it as running.
        messages: The messages received, oldest first.
    """

    created_ns: int
    running: bool = False
    messages: deque[Message] = field(default_factory=lambda: deque(maxlen=MAX_MESSAGES))
    since: float = field(default_factory=time.monotonic)


class Adoption:
    """Looks up unknown goals in batches, running goals first.

    Args:
        history: The store of goals, which other gateways may share.
        adopt: Called with a goal's id, its entry in the history, and its messages.
    """

    def __init__(self, history: History, adopt: Callable[[str, Goal | None, Newcomer], None]) -> None:
        self._history = history
        self._adopt = adopt
        self._newcomers: OrderedDict[str, Newcomer] = OrderedDict()
        self._working = False
        self._tasks = Tasks("looking up goals")

    def hear(self, goal_id: str, message: Message, *, created_ns: int, running: bool) -> None:
        """Take a message about a goal that is not tracked."""
        newcomer = self._newcomers.get(goal_id)
        if newcomer is None:
            if len(self._newcomers) >= MAX_NEWCOMERS and not self._make_room(running=running):
                return
            newcomer = self._newcomers[goal_id] = Newcomer(created_ns)
        newcomer.messages.append(message)
        if running and not newcomer.running:
            newcomer.running = True
            self._newcomers.move_to_end(goal_id, last=False)
        if not self._working:
            self._working = True
            self._tasks.spawn(self._work())

    def _make_room(self, *, running: bool) -> bool:
        """Drop an ended goal to make room for a running one. A running goal is reported again by its server."""
        log.warning("more than %d unknown goals turned up at once; some are left out", MAX_NEWCOMERS)
        last = next(reversed(self._newcomers))
        if not running or self._newcomers[last].running:
            return False
        del self._newcomers[last]
        return True

    def claim(self, goal_id: str) -> list[Message]:
        """Return the messages of a goal that became known in another way, and cancel its lookup."""
        newcomer = self._newcomers.pop(goal_id, None)
        return [] if newcomer is None else list(newcomer.messages)

    async def _work(self) -> None:
        try:
            while self._newcomers:
                goal_ids = list(self._newcomers)
                known = await self._look_up(goal_ids)
                ended = {goal_id for goal_id, goal in (known or {}).items() if goal.status.final}
                others = [goal_id for goal_id in goal_ids if goal_id not in ended]
                for goal_id in (*ended, *others[:BATCH]):
                    self._decide(goal_id, known)
                pause = RETRY_INTERVAL if known is None else BATCH_INTERVAL if len(others) > BATCH else 0.0
                await asyncio.sleep(pause)
        finally:
            self._working = False

    async def _look_up(self, goal_ids: list[str]) -> dict[str, Goal] | None:
        """Return what the history knows about these goals, or None if it does not answer."""
        try:
            return await self._history.known(goal_ids)
        except GatewayError:
            return None
        except Exception:
            log.exception("while looking up goals")
            return None

    def _decide(self, goal_id: str, known: dict[str, Goal] | None) -> None:
        newcomer = self._newcomers.get(goal_id)
        if newcomer is None:  # claimed meanwhile
            return
        impatient = newcomer.running and time.monotonic() - newcomer.since > PATIENCE
        if known is None and not impatient:
            self._newcomers.move_to_end(goal_id)
            return
        del self._newcomers[goal_id]
        try:
            self._adopt(goal_id, (known or {}).get(goal_id), newcomer)
        except Exception:
            log.exception("while taking up goal %s", goal_id)

    async def close(self) -> None:
        """Stop looking up goals."""
        await self._tasks.close()
