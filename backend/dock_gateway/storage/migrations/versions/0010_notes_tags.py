"""Notes and tags on goals."""

import sqlalchemy as sa
from alembic import op

from dock_gateway.storage.tables import UtcTime, identity

revision = "0010"
down_revision = "0009"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Make the tables."""
    op.create_table(
        "goal_tags",
        sa.Column("goal_id", identity(), primary_key=True),
        sa.Column("tag", identity(), primary_key=True),
    )
    op.create_index("goals_by_tag", "goal_tags", ["tag", "goal_id"])
    op.create_table(
        "goal_notes",
        sa.Column("note_id", identity(), primary_key=True),
        sa.Column("goal_id", identity(), nullable=False),
        sa.Column("author", sa.Text, nullable=False),
        sa.Column("written_at", UtcTime, nullable=False),
        sa.Column("text", sa.Text, nullable=False),
    )
    op.create_index("notes_by_goal", "goal_notes", ["goal_id", "written_at", "note_id"])
