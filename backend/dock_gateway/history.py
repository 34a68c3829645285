"""Where goals are kept. In memory for now, behind the interface that a database can take over."""

from collections.abc import Collection
from typing import Protocol

from dock_gateway.goals import Goal, GoalStatus


class History(Protocol):
    """What the gateway asks of any place that keeps goals."""

    async def add(self, goal: Goal, idempotency_key: str | None = None) -> None:
        """Keep a new goal; it is safe once this returns."""

    def record(self, goal: Goal) -> None:
        """Take note of a goal of someone else, or of a change; never waits."""

    async def page(
        self, *, action_name: str, statuses: Collection[GoalStatus], limit: int, before: str | None
    ) -> list[Goal]:
        """Goals on an action, newest first, those older than the goal `before` where it is given."""

    async def get(self, goal_id: str) -> Goal | None:
        """One goal."""

    async def by_key(self, idempotency_key: str) -> Goal | None:
        """The goal that was sent with this key."""


class MemoryHistory:
    """Goals of this process. Of the ended ones the oldest are forgotten beyond `limit`; running ones never."""

    def __init__(self, limit: int) -> None:
        self._limit = limit
        self._goals: dict[str, Goal] = {}  # oldest first
        self._keys: dict[str, str] = {}

    async def add(self, goal: Goal, idempotency_key: str | None = None) -> None:
        """Keep a new goal."""
        if idempotency_key is not None:
            self._keys[idempotency_key] = goal.goal_id
        self.record(goal)

    def record(self, goal: Goal) -> None:
        """Keep a goal, if it is new."""
        self._goals.setdefault(goal.goal_id, goal)
        if len(self._goals) > self._limit:
            self._forget()

    def _forget(self) -> None:
        oldest = next((goal_id for goal_id, goal in self._goals.items() if goal.status.terminal), None)
        if oldest is not None:
            del self._goals[oldest]
            self._keys = {key: goal_id for key, goal_id in self._keys.items() if goal_id != oldest}

    async def page(
        self, *, action_name: str, statuses: Collection[GoalStatus], limit: int, before: str | None
    ) -> list[Goal]:
        """Goals on an action, newest first."""
        newest_first = [goal for goal in reversed(self._goals.values()) if goal.action_name == action_name]
        if before is not None:
            position = next((i for i, goal in enumerate(newest_first) if goal.goal_id == before), len(newest_first))
            newest_first = newest_first[position + 1 :]
        return [goal for goal in newest_first if not statuses or goal.status in statuses][:limit]

    async def get(self, goal_id: str) -> Goal | None:
        """One goal."""
        return self._goals.get(goal_id)

    async def by_key(self, idempotency_key: str) -> Goal | None:
        """The goal that was sent with this key."""
        return self._goals.get(self._keys.get(idempotency_key, ""))
