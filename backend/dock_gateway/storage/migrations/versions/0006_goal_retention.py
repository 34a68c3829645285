"""How much is kept of goals, and which of them have a key."""

import sqlalchemy as sa
from alembic import op

revision = "0006"
down_revision = "0005"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Make the indexes."""
    kept = sa.text("NOT droppable")
    op.create_index("kept_events", "events", ["size"], sqlite_where=kept, postgresql_where=kept)
    op.create_index("keys_by_goal", "idempotency_keys", ["goal_id"])
