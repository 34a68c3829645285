"""A buffer of the newest events, limited in number and in bytes. Plain data."""

from collections import OrderedDict

from dock_gateway.core.event import Event

MAX_BYTES = 32_000_000


class EventBuffer(OrderedDict[str, Event]):
    """Events by id, oldest first. Only `put` and `remove` change it, as they count the bytes.

    Args:
        limit: Maximum number of events. Their data is limited to `MAX_BYTES`.
    """

    def __init__(self, limit: int) -> None:
        super().__init__()
        self._limit = limit
        self._bytes = 0

    def put(self, event: Event) -> list[Event]:
        """Add an event that has an id, unless it is there already; return the events evicted for it."""
        identity = event.id or ""
        if identity in self:
            return []
        self[identity] = event
        self._bytes += len(event.data)
        gone = []
        while len(self) > self._limit or self._bytes > MAX_BYTES:
            _, oldest = self.popitem(last=False)
            self._bytes -= len(oldest.data)
            gone.append(oldest)
        return gone

    def remove(self, event_id: str) -> None:
        """Remove an event if it is there."""
        if (event := self.pop(event_id, None)) is not None:
            self._bytes -= len(event.data)
