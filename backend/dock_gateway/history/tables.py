"""The tables. Encoded JSON is text, as it came; times are UTC; ids are compared byte by byte, as Python does."""

from datetime import UTC, datetime
from typing import Any

import sqlalchemy as sa
from sqlalchemy.engine import Dialect

from dock_gateway.core.goal import Json


class UtcTime(sa.types.TypeDecorator[datetime]):
    """A time in UTC, also in a database that knows no time zones."""

    impl = sa.DateTime(timezone=True)
    cache_ok = True

    def process_bind_param(self, value: datetime | None, dialect: Dialect) -> datetime | None:
        """SQLite gets it without the zone."""
        if value is None:
            return None
        value = value.astimezone(UTC)
        return value.replace(tzinfo=None) if dialect.name == "sqlite" else value

    def process_result_value(self, value: datetime | None, dialect: Dialect) -> datetime | None:
        """And gives it without the zone."""
        if value is None:
            return None
        return value.replace(tzinfo=UTC) if value.tzinfo is None else value.astimezone(UTC)


class JsonText(sa.types.TypeDecorator[Json]):
    """JSON that is encoded already."""

    impl = sa.Text
    cache_ok = True

    def process_bind_param(self, value: Json | None, dialect: Dialect) -> str | None:
        """Bytes are text in UTF-8."""
        return None if value is None else value.decode()

    def process_result_value(self, value: str | None, dialect: Dialect) -> Json | None:
        """And the same bytes again."""
        return None if value is None else value.encode()


def identity() -> Any:
    """The type of an id."""
    return sa.Text().with_variant(sa.Text(collation="C"), "postgresql")


metadata = sa.MetaData()

# As text, not as a parameter: what a database is asked has to say the same as the index, to be found by it.
IS_BATTERY = sa.text("topic = 'battery'")
IS_KEPT = sa.text("NOT droppable")

goals = sa.Table(
    "goals",
    metadata,
    sa.Column("goal_id", identity(), primary_key=True),
    sa.Column("action_name", sa.Text, nullable=False),
    sa.Column("action_type", sa.Text, nullable=False),
    sa.Column("origin", sa.Text, nullable=False),
    sa.Column("status", sa.Text, nullable=False),
    sa.Column("stalled", sa.Boolean, nullable=False),
    sa.Column("goal", JsonText),
    sa.Column("feedback", JsonText),
    sa.Column("result", JsonText),
    sa.Column("error_code", sa.Text),
    sa.Column("error_detail", sa.Text),
    sa.Column("stage", sa.Text),
    sa.Column("retries", sa.Integer),
    sa.Column("created_at", UtcTime, nullable=False),
    sa.Column("updated_at", UtcTime, nullable=False),
    sa.Column("finished_at", UtcTime),
    sa.Column("feedback_count", sa.BigInteger, nullable=False),
    sa.Column("last_event_id", sa.Text),
    sa.Index("goals_by_time", "created_at", "goal_id"),
    sa.Index("goals_by_action", "action_name", "created_at", "goal_id"),
    sa.Index("goals_by_status", "status", "created_at", "goal_id"),
)

events = sa.Table(
    "events",
    metadata,
    sa.Column("id", identity(), primary_key=True),
    sa.Column("topic", sa.Text, nullable=False),
    sa.Column("goal_id", sa.Text),
    sa.Column("action_name", sa.Text),
    sa.Column("robot", sa.Text),
    sa.Column("droppable", sa.Boolean, nullable=False),
    sa.Column("size", sa.Integer, nullable=False),
    sa.Column("data", JsonText, nullable=False),
    sa.Column("key", identity()),  # what happened, by the same name at every gateway
    sa.Index("events_by_goal", "goal_id", "id"),
    sa.Index("events_by_key", "key", unique=True),
    sa.Index("droppable_events", "id", "size"),
    sa.Index("battery_events", "robot", "id"),
    sa.Index("kept_events", "size"),
)

idempotency_keys = sa.Table(
    "idempotency_keys",
    metadata,
    sa.Column("key", sa.Text, primary_key=True),
    sa.Column("goal_id", sa.Text, nullable=False),
    sa.Column("fingerprint", sa.Text, nullable=False),
    sa.Column("expires_at", UtcTime, nullable=False),
    sa.Index("keys_by_expiry", "expires_at"),
    sa.Index("keys_by_goal", "goal_id"),
)

acknowledgements = sa.Table(
    "acknowledgements",
    metadata,
    sa.Column("alert_id", sa.Text, primary_key=True),
    sa.Column("name", sa.Text, nullable=False),
    sa.Column("acknowledged_at", UtcTime, nullable=False),
)

# Of each topic, the newest event that is missing: given up by retention, or for want of memory. Of none, when the
# tables were made: what is later is complete, though no event may have been stored yet.
BEGINNING = ""
horizons = sa.Table(
    "horizons",
    metadata,
    sa.Column("topic", sa.Text, primary_key=True),
    sa.Column("event_id", identity(), nullable=False),
)


def prepare_for(dialect: str) -> None:
    """Say to a dialect, `sqlite` or `postgresql`, of which rows an index is; the other need not be loaded."""
    parts = {"droppable_events": sa.text("droppable"), "battery_events": IS_BATTERY, "kept_events": IS_KEPT}
    for index in events.indexes:
        if index.name in parts:
            index.dialect_kwargs[f"{dialect}_where"] = parts[str(index.name)]
