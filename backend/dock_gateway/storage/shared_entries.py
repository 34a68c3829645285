"""Entries that gateways share through the history: this gateway's copy, and books that people edit."""

import asyncio
from collections.abc import Callable, Collection, Mapping
from contextlib import suppress
from typing import Generic

from dock_gateway.core.errors import NotFound, Unavailable, limit_reached
from dock_gateway.core.versions import UNCONDITIONAL, Condition, entity_tag
from dock_gateway.storage.entries import Dependency, Entries, EntryT

# Seconds between two reads of other gateways' changes.
SYNC_INTERVAL = 2.0


class SharedEntries(Generic[EntryT]):
    """Entries by key: read without waiting, stored in the history, and updated from it by `sync` and `read`.

    Args:
        store: Stores them.
    """

    def __init__(self, store: Entries[EntryT]) -> None:
        self._store = store
        self._known: dict[str, EntryT] = {}
        self._unsaved: dict[str, EntryT | None] = {}
        self._changes = 0
        self._saving = asyncio.Lock()

    @property
    def unsaved(self) -> bool:
        """Whether there are changes that are not stored yet."""
        return bool(self._unsaved)

    def get(self, key: str) -> EntryT | None:
        """Return an entry, or None."""
        return self._known.get(key)

    def keys(self) -> set[str]:
        """Return the keys of all entries."""
        return set(self._known)

    def all(self) -> Mapping[str, EntryT]:
        """Return all entries by their keys."""
        return self._known

    def put(self, key: str, entry: EntryT | None) -> None:
        """Set an entry, or remove it with None. While the history does not answer, that applies to this process only.

        `save` and `sync` store the change.
        """
        self._set(key, entry)
        self._unsaved[key] = entry

    async def store(
        self,
        key: str,
        entry: EntryT | None,
        check: Callable[[Mapping[str, EntryT]], None],
        dependency: Dependency | None = None,
    ) -> None:
        """Store an entry, and only then set it; None removes it.

        Args:
            key: The key.
            entry: The entry.
            check: Is given all stored entries, and raises if this one must not be stored.
            dependency: Entries of another kind that are checked in the same transaction.

        Raises:
            Unavailable: The history does not answer (`history_unavailable`); nothing has changed.
        """
        async with self._saving:
            before = self._unsaved.get(key, ...)
            await self._store.write(key, entry, check, dependency)
            if self._unsaved.get(key, ...) is before:  # else `put` has set something newer meanwhile
                self._unsaved.pop(key, None)
                self._set(key, entry)

    def dependency(self, check: Callable[[Mapping[str, EntryT]], None]) -> Dependency:
        """Return a check of these entries for a write to others."""
        return Dependency(self._store, check)

    def _set(self, key: str, entry: EntryT | None) -> None:
        if entry is None:
            self._known.pop(key, None)
        else:
            self._known[key] = entry
        self._changes += 1

    async def sync(self) -> bool:
        """Store pending changes and read those of other gateways; return False if the history is unavailable."""
        try:
            await self.read()
        except Unavailable:
            return False
        return True

    async def read(self) -> Mapping[str, EntryT]:
        """Store pending changes, read those of other gateways, and return all entries by their keys.

        Raises:
            Unavailable: The history does not answer (`history_unavailable`).
        """
        changes = self._changes  # before `_save`: more may be made while it waits
        await self._save()
        stored = await self._store.read()
        if changes == self._changes:  # else what was read may be outdated
            self._known = stored
        return self._known

    async def save(self) -> None:
        """Store pending changes, if the history answers."""
        with suppress(Unavailable):
            await self._save()

    async def _save(self) -> None:
        async with self._saving:
            for key, entry in list(self._unsaved.items()):
                await self._write(key, entry)
                if self._unsaved[key] is entry:
                    del self._unsaved[key]

    async def _write(self, key: str, entry: EntryT | None) -> None:
        """Store a change that `put` made."""
        await self._store.write(key, entry)


class SharedBook(SharedEntries[EntryT]):
    """Entries that people edit, such as rules, webhooks, tokens and users: each is stored before it counts.

    Args:
        store: Stores them.
        noun: What an entry is called, in errors.
        most: The maximum number of entries.
        by_themselves: The fields that change without a person: they make no new version.
    """

    def __init__(
        self, store: Entries[EntryT], noun: str, most: int, by_themselves: Collection[str] = frozenset()
    ) -> None:
        super().__init__(store)
        self._noun = noun
        self._most = most
        self._by_themselves = by_themselves

    def etag(self, entry: EntryT | None) -> str | None:
        """Return the entity tag of an entry; None if there is no entry."""
        if entry is None:
            return None
        return entity_tag({name: value for name, value in vars(entry).items() if name not in self._by_themselves})

    async def replace(
        self,
        key: str,
        entry: EntryT,
        allow: Callable[[Mapping[str, EntryT]], None] = lambda _: None,
        dependency: Dependency | None = None,
        condition: Condition = UNCONDITIONAL,
    ) -> bool:
        """Store an entry, new or changed; return whether it is new.

        Args:
            key: Its id.
            entry: The entry.
            allow: Is given all entries, and raises if this one must not be stored.
            dependency: Entries of another kind that are checked in the same transaction.
            condition: The version that it must have.

        Raises:
            ChangedMeanwhile: The condition is not true.
            Conflict: There are too many (`limit_reached`).
            Unavailable: The history does not answer (`history_unavailable`); the entry is what it was.
        """
        new = True

        def check(entries: Mapping[str, EntryT]) -> None:
            nonlocal new
            new = key not in entries
            condition.require(self.etag(entries.get(key)))
            if new and len(entries) >= self._most:
                raise limit_reached(self._most, f"{self._noun}s")
            allow(entries)

        await self.store(key, entry, check, dependency)
        return new

    async def find(self, key: str) -> EntryT:
        """Return an entry as it is stored.

        Raises:
            NotFound: There is none.
            Unavailable: The history does not answer (`history_unavailable`).
        """
        entries = await self.read()
        self._require(key, entries)
        return entries[key]

    async def amend(self, key: str, entry: EntryT) -> None:
        """Store a change of an entry, unless the entry was removed meanwhile.

        Raises:
            NotFound: It was removed.
            Unavailable: The history does not answer (`history_unavailable`); the entry is what it was.
        """
        await self.store(key, entry, lambda entries: self._require(key, entries))

    async def remove(self, key: str, condition: Condition = UNCONDITIONAL) -> None:
        """Remove an entry.

        Args:
            key: Its id.
            condition: The version that it must have.

        Raises:
            ChangedMeanwhile: The condition is not true.
            NotFound: `rule_not_found`, `webhook_not_found`, `token_not_found`, ….
            Unavailable: The history does not answer (`history_unavailable`); the entry is still there.
        """

        def check(entries: Mapping[str, EntryT]) -> None:
            self._require(key, entries)
            condition.require(self.etag(entries[key]))

        await self.store(key, None, check)

    def _require(self, key: str, entries: Mapping[str, EntryT]) -> None:
        if key not in entries:
            raise self.missing(key)

    def missing(self, key: str) -> NotFound:
        """Return the error that there is no such entry."""
        return NotFound(f"there is no {self._noun} {key}", code=f"{self._noun}_not_found")
