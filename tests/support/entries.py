"""Keyed entries in memory that several gateways of a test share."""

from collections.abc import Callable, Mapping

from dock_gateway.core.errors import Unavailable
from dock_gateway.history import EntryT
from dock_gateway.history.memory import MemoryEntries


class SharedStore(MemoryEntries[EntryT]):
    """Does not answer where the test says so."""

    away = False

    async def read(self) -> dict[str, EntryT]:
        self.require()
        return await super().read()

    async def write(
        self, key: str, entry: EntryT | None, check: Callable[[Mapping[str, EntryT]], None] | None = None
    ) -> None:
        self.require()
        await super().write(key, entry, check)

    def require(self) -> None:
        if self.away:
            raise Unavailable("away", code="history_unavailable")
