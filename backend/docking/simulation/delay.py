"""Delays: commands and measurements that arrive some time after they were sent."""

from collections import deque
from typing import Generic, TypeVar

from docking.simulation.robot import ROUNDING

Item = TypeVar("Item")


class Delay(Generic[Item]):
    """Holds items back for a time. They arrive in the order in which they were sent."""

    __slots__ = ("_items",)

    def __init__(self) -> None:
        self._items: deque[tuple[float, Item]] = deque()

    def send(self, item: Item, arrives_at: float) -> None:
        """Send an item that arrives at `arrives_at`, in s."""
        self._items.append((arrives_at, item))

    def arrived(self, now: float) -> list[Item]:
        """Take out what has arrived by `now`, in s, oldest first."""
        items = []
        while self._items and self._items[0][0] <= now + ROUNDING:
            items.append(self._items.popleft()[1])
        return items
