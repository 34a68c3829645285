"""What people edit and gateways share through the history: rules, webhooks, tokens, users."""

from collections.abc import Callable, Mapping

from dock_gateway.core.errors import Conflict, NotFound
from dock_gateway.fleet.shared_entries import SharedEntries
from dock_gateway.storage import Beside, Entries, EntryT


class SharedBook(SharedEntries[EntryT]):
    """A limited number of entries by id, each stored before it counts.

    Args:
        store: Stores them.
        noun: What an entry is called, in errors.
        most: The maximum number of entries.
    """

    def __init__(self, store: Entries[EntryT], noun: str, most: int) -> None:
        super().__init__(store)
        self._noun = noun
        self._most = most

    async def replace(
        self,
        key: str,
        entry: EntryT,
        allow: Callable[[Mapping[str, EntryT]], None] = lambda _: None,
        beside: Beside | None = None,
    ) -> None:
        """Store an entry, new or changed.

        Args:
            key: Its id.
            entry: The entry.
            allow: Is given all entries, and raises if this one must not be stored.
            beside: Entries of another kind that are checked at the same moment.

        Raises:
            Conflict: There are too many (`too_many_rules`, `too_many_webhooks`).
            Unavailable: The history does not answer (`history_unavailable`); the entry is what it was.
        """

        def check(entries: Mapping[str, EntryT]) -> None:
            if key not in entries and len(entries) >= self._most:
                detail = f"there are {self._most} {self._noun}s; remove one first"
                raise Conflict(detail, code=f"too_many_{self._noun}s")
            allow(entries)

        await self.store(key, entry, check, beside)

    async def amend(self, key: str, entry: EntryT) -> None:
        """Store a change of an entry, unless the entry was removed meanwhile.

        Raises:
            NotFound: It was removed.
            Unavailable: The history does not answer (`history_unavailable`); the entry is what it was.
        """
        await self.store(key, entry, lambda entries: self._require(key, entries))

    async def remove(self, key: str) -> None:
        """Remove an entry.

        Raises:
            NotFound: `rule_not_found`, `webhook_not_found`, `token_not_found`, ….
            Unavailable: The history does not answer (`history_unavailable`); the entry is still there.
        """
        await self.store(key, None, lambda entries: self._require(key, entries))

    def _require(self, key: str, entries: Mapping[str, EntryT]) -> None:
        if key not in entries:
            raise self.missing(key)

    def missing(self, key: str) -> NotFound:
        """Return the error that there is no such entry."""
        return NotFound(f"there is no {self._noun} {key}", code=f"{self._noun}_not_found")
