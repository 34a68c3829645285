"""Entries by key, each stored as a JSON document in a database that several gateways may share."""

from collections.abc import Callable, Mapping
from typing import Any, Generic, NamedTuple, TypeVar

import sqlalchemy as sa
from pydantic import TypeAdapter

from dock_gateway.storage.immediate import ImmediateWriter
from dock_gateway.storage.queries import insert_into
from dock_gateway.storage.reader import Reader
from dock_gateway.storage.tables import documents

EntryT = TypeVar("EntryT")


class Dependency(NamedTuple):
    """Entries of another kind that a write depends on.

    Attributes:
        entries: Where they are stored.
        check: Is given all of them, and raises if the write must not happen.
    """

    entries: "Entries[Any]"
    check: Callable[[Mapping[str, Any]], None]


class Entries(Generic[EntryT]):
    """Stores the entries of one kind by key.

    Args:
        reader: Reads from the database.
        writer: Writes to it.
        kind: The kind.
        model: The dataclass or pydantic model of an entry.
    """

    def __init__(self, reader: Reader, writer: ImmediateWriter, kind: str, model: type[EntryT]) -> None:
        self._reader = reader
        self._writer = writer
        self._kind = kind
        self._json = TypeAdapter(model)
        self._all = sa.select(documents.c.key, documents.c.document).where(documents.c.kind == kind)

    async def read(self) -> dict[str, EntryT]:
        """Return all entries by their keys.

        Raises:
            Unavailable: The database does not answer (`history_unavailable`).
        """
        return await self._reader.read(self._read)

    async def get(self, key: str) -> EntryT | None:
        """Return one entry; None if there is none.

        Raises:
            Unavailable: The database does not answer (`history_unavailable`).
        """
        return (await self._reader.read(self._read, key)).get(key)

    async def write(
        self,
        key: str,
        entry: EntryT | None,
        check: Callable[[Mapping[str, EntryT]], None] | None = None,
        dependency: Dependency | None = None,
    ) -> None:
        """Store an entry, replacing the earlier one; None deletes it.

        Args:
            key: The key.
            entry: The entry.
            check: Is given all entries, and raises if this one must not be stored. No other gateway can write between
                the check and the write.
            dependency: Entries of the same history that are checked, too.

        Raises:
            Unavailable: The database does not answer (`history_unavailable`).
        """
        await self._writer.write(self._write, key, entry, check, dependency)

    def _read(self, connection: sa.Connection, key: str | None = None) -> dict[str, EntryT]:
        rows = connection.execute(self._all if key is None else self._all.where(documents.c.key == key))
        return {key: self._json.validate_json(document, extra="ignore") for key, document in rows}

    def _write(
        self,
        connection: sa.Connection,
        key: str,
        entry: EntryT | None,
        check: Callable[[Mapping[str, EntryT]], None] | None,
        dependency: Dependency | None,
    ) -> None:
        checks: list[tuple[Entries[Any], Callable[[Mapping[str, Any]], None]]] = []
        if check is not None:
            checks.append((self, check))
        if dependency is not None:
            checks.append((dependency.entries, dependency.check))
        if checks and connection.dialect.name == "postgresql":  # SQLite has only one writer at a time anyway
            connection.execute(sa.text(f"LOCK TABLE {documents.name} IN SHARE ROW EXCLUSIVE MODE"))
        for entries, require in checks:
            require(entries._read(connection))  # noqa: SLF001 - of this class
        identity = {"kind": self._kind, "key": key}
        if entry is None:
            is_it = (documents.c[name] == value for name, value in identity.items())
            connection.execute(sa.delete(documents).where(*is_it))
            return
        row = identity | {"document": self._json.dump_json(entry)}
        insert = insert_into(connection.dialect.name, documents)
        connection.execute(insert.on_conflict_do_update(index_elements=[*identity], set_=row), row)
