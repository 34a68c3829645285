"""Things that several robots share, such as the map of a hall: made for the first, closed after the last."""

from collections.abc import Callable
from typing import Generic, Protocol, TypeVar


class Closable(Protocol):
    """Something that a pool holds."""

    async def close(self) -> None:
        """End it."""


T = TypeVar("T", bound=Closable)


class Pool(Generic[T]):
    """Shared parts by their topic.

    Args:
        make: Makes the part of a topic.
    """

    def __init__(self, make: Callable[[str], T]) -> None:
        self._make = make
        self._parts: dict[str, T] = {}
        self._users: dict[str, int] = {}

    def take(self, topic: str) -> T:
        """Return the part of a topic; `give` it back after use."""
        if topic not in self._parts:
            self._parts[topic] = self._make(topic)
        self._users[topic] = self._users.get(topic, 0) + 1
        return self._parts[topic]

    async def give(self, topic: str) -> None:
        """Give a part back. The last user's is closed."""
        self._users[topic] -= 1
        if not self._users[topic]:
            del self._users[topic]
            await self._parts.pop(topic).close()
