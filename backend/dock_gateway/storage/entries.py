"""Small tables of keyed entries, in a database that several gateways may share, or in memory."""

from collections.abc import Callable, Mapping
from typing import Any, Generic

import sqlalchemy as sa

from dock_gateway.storage.immediate import ImmediateWriter
from dock_gateway.storage.protocol import Beside, EntryT, ModelT
from dock_gateway.storage.queries import insert_into
from dock_gateway.storage.reader import Reader
from dock_gateway.storage.tables import documents


class SqlEntries(Generic[EntryT]):
    """The entries of one table.

    Args:
        reader: Reads from the database.
        writer: Writes to it.
        table: The key, then the fields of an entry in their order.
        make: The dataclass of an entry.
    """

    def __init__(self, reader: Reader, writer: ImmediateWriter, table: sa.Table, make: Callable[..., EntryT]) -> None:
        self._reader = reader
        self._writer = writer
        self._table = table
        self._make = make

    async def read(self) -> dict[str, EntryT]:
        """Return all entries by their keys.

        Raises:
            Unavailable: The database does not answer (`history_unavailable`).
        """
        return await self._reader.read(self._read)

    async def write(
        self,
        key: str,
        entry: EntryT | None,
        check: Callable[[Mapping[str, EntryT]], None] | None = None,
        beside: Beside | None = None,
    ) -> None:
        """Store an entry, replacing the earlier one; None deletes it.

        Args:
            key: The key.
            entry: The entry.
            check: Is given all entries in the same transaction, and raises if this one must not be stored.
            beside: Entries of the same database that are checked in that transaction, too.

        Raises:
            Unavailable: The database does not answer (`history_unavailable`).
        """
        await self._writer.write(self._write, key, entry, check, beside)

    def _read(self, connection: sa.Connection) -> dict[str, EntryT]:
        return {key: self._make(*fields) for key, *fields in connection.execute(sa.select(self._table))}

    def _identify(self, key: str) -> dict[str, str]:
        """Return the columns of the primary key."""
        (name,) = self._table.primary_key.columns.keys()
        return {name: key}

    def _describe(self, entry: EntryT) -> dict[str, Any]:
        """Return the other columns."""
        names = self._table.columns.keys()[1:]
        return dict(zip(names, vars(entry).values(), strict=True))

    def _write(
        self,
        connection: sa.Connection,
        key: str,
        entry: EntryT | None,
        check: Callable[[Mapping[str, EntryT]], None] | None,
        beside: Beside | None,
    ) -> None:
        checks: list[tuple[SqlEntries[Any], Callable[[Mapping[str, Any]], None]]] = []
        if check is not None:
            checks.append((self, check))
        if beside is not None:
            assert isinstance(beside.entries, SqlEntries)
            checks.append((beside.entries, beside.check))
        if checks and connection.dialect.name == "postgresql":  # SQLite has only one writer at a time anyway
            # In one order, so that no two writers wait for each other.
            names = ", ".join(sorted(entries._table.name for entries, _ in checks))  # noqa: SLF001 - of this class
            connection.execute(sa.text(f"LOCK TABLE {names} IN SHARE ROW EXCLUSIVE MODE"))
        for entries, require in checks:
            require(entries._read(connection))  # noqa: SLF001 - as above
        identity = self._identify(key)
        if entry is None:
            connection.execute(
                sa.delete(self._table).where(*(self._table.c[name] == identity[name] for name in identity))
            )
            return
        row = identity | self._describe(entry)
        insert = insert_into(connection.dialect.name, self._table)
        connection.execute(insert.on_conflict_do_update(index_elements=[*identity], set_=row), row)


class SqlDocuments(SqlEntries[ModelT]):
    """The documents of one kind.

    Args:
        reader: Reads from the database.
        writer: Writes to it.
        kind: The kind.
        model: What a document is.
    """

    def __init__(self, reader: Reader, writer: ImmediateWriter, kind: str, model: type[ModelT]) -> None:
        super().__init__(reader, writer, documents, model)
        self._kind = kind
        self._model = model

    def _read(self, connection: sa.Connection) -> dict[str, ModelT]:
        query = sa.select(documents.c.key, documents.c.document).where(documents.c.kind == self._kind)
        return {
            key: self._model.model_validate_json(document, extra="ignore")
            for key, document in connection.execute(query)
        }

    def _identify(self, key: str) -> dict[str, str]:
        return {"kind": self._kind, "key": key}

    def _describe(self, entry: ModelT) -> dict[str, Any]:
        return {"document": entry.model_dump_json().encode()}


class MemoryEntries(Generic[EntryT]):
    """Keyed entries in memory."""

    def __init__(self) -> None:
        self._known: dict[str, EntryT] = {}

    async def read(self) -> dict[str, EntryT]:
        """Return all entries by their keys."""
        return dict(self._known)

    async def write(
        self,
        key: str,
        entry: EntryT | None,
        check: Callable[[Mapping[str, EntryT]], None] | None = None,
        beside: Beside | None = None,
    ) -> None:
        """Store an entry, replacing the earlier one; None deletes it."""
        if beside is not None:
            beside.check(await beside.entries.read())
        if check is not None:
            check(self._known)
        if entry is None:
            self._known.pop(key, None)
        else:
            self._known[key] = entry
