"""The tables."""

import sqlalchemy as sa

from dock_gateway.storage.column_types import JsonText, UtcTime, identity

metadata = sa.MetaData()

# Text, not a parameter: a query must have the same text as the index's condition for the index to be used.
IS_BATTERY = sa.text("topic = 'battery'")
IS_DROPPABLE = sa.text("droppable")
IS_KEPT = sa.text("NOT droppable")
HAS_ERROR = sa.text("error_code IS NOT NULL")

goals = sa.Table(
    "goals",
    metadata,
    sa.Column("goal_id", identity(), primary_key=True),
    sa.Column("action_name", sa.Text, nullable=False),
    sa.Column("action_type", sa.Text, nullable=False),
    sa.Column("verb", sa.Text),
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
    sa.Index("goals_by_error", "error_code", "created_at", "goal_id"),
    # All columns of the statistics, so that they are read without the messages, which are 20 times as large.
    sa.Index("goals_by_end", "created_at", "action_name", "status", "error_code", "retries", "finished_at"),
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
    sa.Column("key", identity()),  # names what happened; the same at every gateway
    sa.Index("events_by_goal", "goal_id", "id"),
    sa.Index("events_by_key", "key", unique=True),
    sa.Index("droppable_events", "id", "size"),
    sa.Index("battery_events", "robot", "id"),
    # With `droppable`, which SQLite would otherwise read in the table, though the index has only those that are not.
    sa.Index("kept_events", "action_name", "size", "droppable"),
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

goal_tags = sa.Table(
    "goal_tags",
    metadata,
    sa.Column("goal_id", identity(), primary_key=True),
    sa.Column("tag", identity(), primary_key=True),
    sa.Index("goals_by_tag", "tag", "goal_id"),
)

goal_notes = sa.Table(
    "goal_notes",
    metadata,
    sa.Column("note_id", identity(), primary_key=True),
    sa.Column("goal_id", identity(), nullable=False),
    sa.Column("author", sa.Text, nullable=False),
    sa.Column("written_at", UtcTime, nullable=False),
    sa.Column("text", sa.Text, nullable=False),
    sa.Index("notes_by_goal", "goal_id", "written_at", "note_id"),
)

# Rules, webhooks, users and all else that is read and written as a whole: one row each, by kind and key.
documents = sa.Table(
    "documents",
    metadata,
    sa.Column("kind", sa.Text, primary_key=True),
    sa.Column("key", sa.Text, primary_key=True),
    sa.Column("document", JsonText, nullable=False),
)

audit = sa.Table(
    "audit",
    metadata,
    sa.Column("sequence", sa.BigInteger, primary_key=True, autoincrement=False),
    sa.Column("id", sa.Text, nullable=False),
    sa.Column("acted_at", UtcTime, nullable=False),
    sa.Column("principal", sa.Text),
    sa.Column("role", sa.Text),
    sa.Column("token_id", sa.Text),
    sa.Column("client", sa.Text),
    sa.Column("request_id", sa.Text),
    sa.Column("what", sa.Text, nullable=False),
    sa.Column("robot", sa.Text),
    sa.Column("action_name", sa.Text),
    sa.Column("goal_id", sa.Text),
    sa.Column("subject", sa.Text),
    sa.Column("status", sa.Integer, nullable=False),
    sa.Column("code", sa.Text),
    sa.Column("digest", sa.Text, nullable=False),
    sa.Index("audit_by_entry", "id", unique=True),
    sa.Index("audit_by_principal", "principal", "sequence"),
    sa.Index("audit_by_what", "what", "sequence"),
    sa.Index("audit_by_goal", "goal_id", "sequence"),
)

# One row: the last row of the audit log that was deleted for its age, and the last one that was written.
audit_chain = sa.Table(
    "audit_chain",
    metadata,
    sa.Column("chain_id", sa.Integer, primary_key=True, autoincrement=False),
    sa.Column("anchor_sequence", sa.BigInteger, nullable=False),
    sa.Column("anchor_digest", sa.Text, nullable=False),
    sa.Column("head_sequence", sa.BigInteger, nullable=False),
    sa.Column("head_digest", sa.Text, nullable=False),
)

# The newest missing event of each topic, dropped by retention or because memory was full. The row with an empty topic
# is the time when the tables were made: later events are complete, even if none is stored yet.
BEGINNING = ""
# The topic of the row that says up to which id gateways may have published; see `order.py`.
REACHED = "~"
horizons = sa.Table(
    "horizons",
    metadata,
    sa.Column("topic", sa.Text, primary_key=True),
    sa.Column("event_id", identity(), nullable=False),
)


# One row: the revision of these tables. Alembic calls it so, and can upgrade them after the first release.
revisions = sa.Table("alembic_version", metadata, sa.Column("version_num", sa.String(32), primary_key=True))


def prepare_for(dialect: str) -> None:
    """Set the conditions of the partial indexes for `sqlite` or `postgresql`; the other need not be loaded."""
    parts = {
        "droppable_events": IS_DROPPABLE,
        "battery_events": IS_BATTERY,
        "kept_events": IS_KEPT,
        "goals_by_error": HAS_ERROR,
    }
    for index in (*events.indexes, *goals.indexes):
        if index.name in parts:
            index.dialect_kwargs[f"{dialect}_where"] = parts[str(index.name)]
