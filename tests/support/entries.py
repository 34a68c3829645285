"""Keyed entries in memory that several gateways of a test share."""

import asyncio
from collections.abc import Callable, Mapping

from dock_gateway.core.errors import Unavailable
from dock_gateway.storage import Dependency, EntryT
from dock_gateway.storage.entries import MemoryEntries


class SharedStore(MemoryEntries[EntryT]):
    """Does not answer, or slowly, where the test says so."""

    def __init__(self) -> None:
        super().__init__()
        self.away = False
        self.gate = asyncio.Event()
        self.gate.set()

    async def read(self) -> dict[str, EntryT]:
        self.require()
        found = await super().read()
        await self.gate.wait()
        return found

    async def write(
        self,
        key: str,
        entry: EntryT | None,
        check: Callable[[Mapping[str, EntryT]], None] | None = None,
        dependency: Dependency | None = None,
    ) -> None:
        self.require()
        await super().write(key, entry, check, dependency)

    def require(self) -> None:
        if self.away:
            raise Unavailable("away", code="history_unavailable")
