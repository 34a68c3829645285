"""Why goals were rejected or aborted, as far as their servers say so."""

import asyncio
from collections import OrderedDict

from dock_gateway.goals import GoalError

# A rejected or aborted goal waits so many seconds for a server that says why.
REASON_WAIT = 0.3
MAX_REMEMBERED = 2000


class Reasons:
    """Reasons by goal id; they may come before or after the rejection itself."""

    def __init__(self) -> None:
        self._reasons: OrderedDict[str, GoalError] = OrderedDict()
        self._waiting: dict[str, asyncio.Event] = {}

    def __len__(self) -> int:
        return len(self._reasons)

    def hear(self, goal_id: str, error: GoalError) -> None:
        """A server said why."""
        self._reasons[goal_id] = error
        if len(self._reasons) > MAX_REMEMBERED:
            self._reasons.popitem(last=False)
        if event := self._waiting.get(goal_id):
            event.set()

    async def of(self, goal_id: str) -> GoalError | None:
        """The reason, for which it waits a moment, or None."""
        if goal_id not in self._reasons:
            event = self._waiting.setdefault(goal_id, asyncio.Event())
            try:
                async with asyncio.timeout(REASON_WAIT):
                    await event.wait()
            except TimeoutError:
                return None
            finally:
                self._waiting.pop(goal_id, None)
        return self._reasons.get(goal_id)
