"""The last goal that ended, the last that ran and the last that succeeded, for the watched actions."""

import asyncio
import logging
from collections.abc import Iterable

from dock_gateway.core.errors import Unavailable
from dock_gateway.core.goal import Goal, GoalStatus
from dock_gateway.core.tasks import cancel
from dock_gateway.storage import GoalFilter, History

log = logging.getLogger(__name__)

FINAL = frozenset(status for status in GoalStatus if status.final)
SUCCEEDED = frozenset({GoalStatus.SUCCEEDED})
# Number of goals of an action to read; an action server that was running before us may report them again.
READ = 10


class LastGoals:
    """Keeps how goals ended, from the history at first, then from the goals seen.

    Args:
        history: Stores goals.
        retry_interval: Seconds before the history is queried again if it does not answer.
    """

    def __init__(self, history: History, retry_interval: float = 1.0) -> None:
        self._history = history
        self._retry_interval = retry_interval
        self._watched: set[str] = set()
        self._last: dict[str, Goal] = {}
        self._ran: dict[str, Goal] = {}
        self._succeeded: dict[str, Goal] = {}
        self._read: set[str] = set()  # ids of goals read from the history
        self._unread: asyncio.Queue[str] = asyncio.Queue()
        self._task = asyncio.create_task(self._read_on())

    def watch(self, *action_names: str) -> None:
        """Record the outcomes of goals on these actions from now on, and read earlier ones from the history."""
        for name in action_names:
            if name not in self._watched:
                self._watched.add(name)
                self._unread.put_nowait(name)

    def take(self, goal: Goal) -> None:
        """Record a goal that has ended."""
        if goal.action_name not in self._watched or goal.goal_id in self._read:
            return
        self._last[goal.action_name] = latest([self._last.get(goal.action_name), goal]) or goal
        if goal.status is not GoalStatus.REJECTED:
            self._ran[goal.action_name] = latest([self._ran.get(goal.action_name), goal]) or goal
        if goal.status is GoalStatus.SUCCEEDED:
            self._succeeded[goal.action_name] = latest([self._succeeded.get(goal.action_name), goal]) or goal

    def last(self, *action_names: str) -> Goal | None:
        """Return the last goal on these actions that ended."""
        return latest(self._last.get(name) for name in action_names)

    def ran(self, *action_names: str) -> Goal | None:
        """Return the last goal on these actions that ended and was not rejected."""
        return latest(self._ran.get(name) for name in action_names)

    def succeeded(self, *action_names: str) -> Goal | None:
        """Return the last goal on these actions that succeeded."""
        return latest(self._succeeded.get(name) for name in action_names)

    async def _read_on(self) -> None:
        while True:
            name = await self._unread.get()
            if not await self._look_up(name):
                self._unread.put_nowait(name)
                await asyncio.sleep(self._retry_interval)

    async def _look_up(self, name: str) -> bool:
        try:
            found = await self._history.page(GoalFilter(frozenset({name}), statuses=FINAL), limit=READ)
            if not any(goal.status is GoalStatus.SUCCEEDED for goal in found):
                found += await self._history.page(GoalFilter(frozenset({name}), statuses=SUCCEEDED), limit=1)
        except Unavailable:
            return False
        except Exception:
            log.exception("while reading the last goals on %s", name)
            return True
        for goal in found:
            self.take(goal)
        self._read |= {goal.goal_id for goal in found}
        return True

    async def close(self) -> None:
        """Stop reading from the history."""
        await cancel(self._task)


def latest(goals: Iterable[Goal | None]) -> Goal | None:
    """Return the ended goal that ran last; of two equal ones, the first in the list."""
    last: Goal | None = None
    for goal in goals:
        if goal is not None and (last is None or _follows(goal, last)):
            last = goal
    return last


def _follows(goal: Goal, last: Goal) -> bool:
    if GoalStatus.REJECTED in (goal.status, last.status):  # it never ran, perhaps because the other one did
        return (goal.finished_at or goal.created_at) > (last.finished_at or last.created_at)
    return goal.created_at > last.created_at
