"""Goals, events, idempotency keys.

Written out, and not taken from `tables.py`: this is how the tables were then, whatever they become.
"""

import sqlalchemy as sa
from alembic import op

revision = "0001"
down_revision = None
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Make the first tables."""
    text_id = sa.Text().with_variant(sa.Text(collation="C"), "postgresql")
    time = sa.DateTime(timezone=True)
    op.create_table(
        "goals",
        sa.Column("goal_id", text_id, primary_key=True),
        sa.Column("action_name", sa.Text, nullable=False),
        sa.Column("action_type", sa.Text, nullable=False),
        sa.Column("origin", sa.Text, nullable=False),
        sa.Column("status", sa.Text, nullable=False),
        sa.Column("stalled", sa.Boolean, nullable=False),
        sa.Column("goal", sa.Text),
        sa.Column("feedback", sa.Text),
        sa.Column("result", sa.Text),
        sa.Column("error_code", sa.Text),
        sa.Column("error_detail", sa.Text),
        sa.Column("created_at", time, nullable=False),
        sa.Column("updated_at", time, nullable=False),
        sa.Column("finished_at", time),
        sa.Column("feedback_count", sa.BigInteger, nullable=False),
        sa.Column("last_event_id", sa.Text),
    )
    op.create_index("goals_by_time", "goals", ["created_at", "goal_id"])
    op.create_index("goals_by_action", "goals", ["action_name", "created_at", "goal_id"])
    op.create_index("goals_by_status", "goals", ["status", "created_at", "goal_id"])
    op.create_table(
        "events",
        sa.Column("id", text_id, primary_key=True),
        sa.Column("topic", sa.Text, nullable=False),
        sa.Column("goal_id", sa.Text),
        sa.Column("action_name", sa.Text),
        sa.Column("robot", sa.Text),
        sa.Column("droppable", sa.Boolean, nullable=False),
        sa.Column("size", sa.Integer, nullable=False),
        sa.Column("data", sa.Text, nullable=False),
    )
    op.create_index("events_by_goal", "events", ["goal_id", "id"])
    droppable = sa.text("droppable")
    op.create_index("droppable_events", "events", ["id", "size"], sqlite_where=droppable, postgresql_where=droppable)
    op.create_table(
        "idempotency_keys",
        sa.Column("key", sa.Text, primary_key=True),
        sa.Column("goal_id", sa.Text, nullable=False),
        sa.Column("fingerprint", sa.Text, nullable=False),
        sa.Column("expires_at", time, nullable=False),
    )
    op.create_index("keys_by_expiry", "idempotency_keys", ["expires_at"])
    op.create_table(
        "horizons",
        sa.Column("topic", sa.Text, primary_key=True),
        sa.Column("event_id", text_id, nullable=False),
    )
