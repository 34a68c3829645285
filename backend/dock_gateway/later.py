"""Facts about a goal that come by another way than the goal itself, and may come a moment before or after it."""

import asyncio
from collections import OrderedDict
from typing import Generic, TypeVar

T = TypeVar("T")

MAX_REMEMBERED = 2000


class Later(Generic[T]):
    """A fact about each goal, such as why it was rejected; who asks for it waits a moment.

    Args:
        wait: How many seconds.
    """

    def __init__(self, wait: float) -> None:
        self._wait = wait
        self._facts: OrderedDict[str, T] = OrderedDict()
        self._waiting: dict[str, asyncio.Event] = {}

    def __len__(self) -> int:
        return len(self._facts)

    def __contains__(self, goal_id: str) -> bool:
        return goal_id in self._facts

    def put(self, goal_id: str, fact: T) -> None:
        """The fact has come; a newer one takes its place."""
        self._facts[goal_id] = fact
        if len(self._facts) > MAX_REMEMBERED:
            self._facts.popitem(last=False)
        if event := self._waiting.get(goal_id):
            event.set()

    async def of(self, goal_id: str) -> T | None:
        """The fact, for which it waits a moment, or None."""
        if goal_id not in self._facts:
            event = self._waiting.setdefault(goal_id, asyncio.Event())
            try:
                async with asyncio.timeout(self._wait):
                    await event.wait()
            except TimeoutError:
                return None
            finally:
                self._waiting.pop(goal_id, None)
        return self._facts.get(goal_id)
