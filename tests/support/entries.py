"""Keyed entries in a dictionary, which several gateways of a test may share."""

import asyncio
from collections.abc import Callable, Mapping

from dock_gateway.core.errors import Unavailable
from dock_gateway.storage import Dependency, Entries, EntryT


class EntriesInMemory(Entries[EntryT]):
    """Stores entries, as `Entries` does.

    Attributes:
        known: The entries, by key.
    """

    def __init__(self) -> None:
        self.known: dict[str, EntryT] = {}

    async def read(self) -> dict[str, EntryT]:
        return dict(self.known)

    async def get(self, key: str) -> EntryT | None:
        return (await self.read()).get(key)

    async def write(
        self,
        key: str,
        entry: EntryT | None,
        check: Callable[[Mapping[str, EntryT]], None] | None = None,
        dependency: Dependency | None = None,
    ) -> None:
        if dependency is not None:
            dependency.check(await dependency.entries.read())
        if check is not None:
            check(self.known)
        if entry is None:
            self.known.pop(key, None)
        else:
            self.known[key] = entry


class SharedStore(EntriesInMemory[EntryT]):
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
