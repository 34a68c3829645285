"""One new row in SQLite, in as few steps as there are: what the sender of a goal waits for.

SQLAlchemy writes the statement and says how each value is stored. To have it execute the statement, too, would take
ten times as long as SQLite does, and most of that while the answer of the action server is coming in.
"""

import sqlite3
import threading
from collections.abc import Callable
from typing import Any

import sqlalchemy as sa
from sqlalchemy.dialects.sqlite import insert

from dock_gateway.history.rows import Row


class Insertion:
    """Inserts rows into a table where they are new, each in a transaction of its own; for any thread.

    Args:
        engine: Of connections that begin no transactions by themselves. One of them is kept.
        table: The table.
    """

    def __init__(self, engine: sa.Engine, table: sa.Table) -> None:
        self._engine = engine
        self._connection: sa.PoolProxiedConnection | None = None
        self._lock = threading.Lock()
        dialect = engine.dialect
        compiled = insert(table).on_conflict_do_nothing().compile(dialect=dialect)
        names: list[str] = list(compiled.positiontup or ())
        self._statement = str(compiled)
        self._values: list[tuple[str, Callable[[Any], Any] | None]] = [
            (name, table.c[name].type.dialect_impl(dialect).bind_processor(dialect)) for name in names
        ]

    def add(self, row: Row) -> bool:
        """Insert a row; it is on the disk once this returns True. Where it is False nothing was changed.

        Raises:
            OperationalError: The database is locked, full or away.
        """
        try:
            values = [row[name] if store is None else store(row[name]) for name, store in self._values]
            with self._lock:
                if self._connection is None:
                    self._connection = self._engine.raw_connection()
                cursor = self._connection.cursor()
                try:
                    cursor.execute(self._statement, values)
                    return bool(cursor.rowcount == 1)
                finally:
                    cursor.close()
        except sqlite3.OperationalError as error:
            self.close()
            raise sa.exc.OperationalError(self._statement, None, error) from error
        except (sqlite3.Error, ValueError):
            self.close()
            return False

    def close(self) -> None:
        """Give the connection back."""
        with self._lock:
            connection, self._connection = self._connection, None
            if connection is not None:
                connection.invalidate()
