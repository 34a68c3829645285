"""The types of columns. Encoded JSON is stored unchanged as text, times are UTC, and ids compare byte by byte."""

from datetime import UTC, datetime
from typing import Any

import orjson
import sqlalchemy as sa
from sqlalchemy.engine import Dialect

from dock_gateway.core.goal import Json


class UtcTime(sa.types.TypeDecorator[datetime]):
    """A time in UTC, also in a database without time zones."""

    impl = sa.DateTime(timezone=True)
    cache_ok = True

    def process_bind_param(self, value: datetime | None, dialect: Dialect) -> datetime | None:
        """Convert to UTC; drop the zone for SQLite."""
        if value is None:
            return None
        value = value.astimezone(UTC)
        return value.replace(tzinfo=None) if dialect.name == "sqlite" else value

    def process_result_value(self, value: datetime | None, dialect: Dialect) -> datetime | None:
        """Add the zone that SQLite does not store."""
        if value is None:
            return None
        return value.replace(tzinfo=UTC) if value.tzinfo is None else value.astimezone(UTC)


class JsonText(sa.types.TypeDecorator[Json]):
    """Encoded JSON."""

    impl = sa.Text
    cache_ok = True

    def process_bind_param(self, value: Json | None, dialect: Dialect) -> str | None:
        """Decode UTF-8 bytes to text."""
        return None if value is None else value.decode()

    def process_result_value(self, value: str | None, dialect: Dialect) -> Json | None:
        """Encode the text to the same bytes."""
        return None if value is None else value.encode()


class Names(sa.types.TypeDecorator[tuple[str, ...]]):
    """Names, as a JSON array."""

    impl = sa.Text
    cache_ok = True

    def process_bind_param(self, value: tuple[str, ...] | None, dialect: Dialect) -> str | None:
        """Encode the names."""
        return None if value is None else orjson.dumps(value).decode()

    def process_result_value(self, value: str | None, dialect: Dialect) -> tuple[str, ...] | None:
        """Decode the names."""
        return None if value is None else tuple(orjson.loads(value))


def identity() -> Any:
    """Return the column type of an id."""
    return sa.Text().with_variant(sa.Text(collation="C"), "postgresql")
