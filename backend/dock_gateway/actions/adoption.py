"""Goals that turn up by themselves: another client's, another gateway's, or ours from before a restart.

Nothing is said of such a goal until the history has been asked about it: it may be ours, and it may have ended long
ago. A ROS node that makes up goals by the thousand is slowed down here, before it costs anyone else anything.
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

# What a message means for a goal, once that is known.
Message = Callable[[Goal], None]

# Goals that are taken up together, and the seconds between two such batches: 100 goals a second. All that wait are
# looked up at once, and those that have ended cost no more than that.
BATCH, BATCH_INTERVAL = 50, 0.5
# Goals that wait to be looked up, and messages of each that wait with it.
MAX_NEWCOMERS, MAX_MESSAGES = 1000, 100
# Seconds that a goal which runs is kept back while the history does not answer.
PATIENCE = 0.5
RETRY_INTERVAL = 0.1


@dataclass
class Newcomer:
    """A goal that waits to be looked up.

    Attributes:
        created_ns: When it was first heard of, or accepted where that is known; nanoseconds since 1970.
        running: Whether it was heard of as one that has not ended.
        messages: What was heard, oldest first.
    """

    created_ns: int
    running: bool = False
    messages: deque[Message] = field(default_factory=lambda: deque(maxlen=MAX_MESSAGES))
    since: float = field(default_factory=time.monotonic)


class Adoption:
    """Looks up goals that turned up, in batches, those that run first.

    Args:
        history: Where goals are kept, also by other gateways.
        adopt: Called with the id of a goal, what the history knows of it, and what was heard of it.
    """

    def __init__(self, history: History, adopt: Callable[[str, Goal | None, Newcomer], None]) -> None:
        self._history = history
        self._adopt = adopt
        self._newcomers: OrderedDict[str, Newcomer] = OrderedDict()
        self._working = False
        self._tasks = Tasks("looking up goals")

    def hear(self, goal_id: str, message: Message, *, created_ns: int, running: bool) -> None:
        """Something was heard of a goal that is not tracked."""
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
        """Give up the goal that matters least, one that has ended; one that runs is told of again."""
        log.warning("more than %d unknown goals turned up at once; some are left out", MAX_NEWCOMERS)
        last = next(reversed(self._newcomers))
        if not running or self._newcomers[last].running:
            return False
        del self._newcomers[last]
        return True

    def claim(self, goal_id: str) -> list[Message]:
        """What was heard of a goal that has become known in another way; it is not looked up any more."""
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
        """What the history knows of these goals; None where it does not answer."""
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
        """Look up nothing any more."""
        await self._tasks.close()
