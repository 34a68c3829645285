"""The display names and groups of robots."""

import sqlalchemy as sa
from alembic import op

revision = "0009"
down_revision = "0008"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Make the table."""
    op.create_table(
        "robot_labels",
        sa.Column("robot", sa.Text, primary_key=True),
        sa.Column("display_name", sa.Text),
        sa.Column("groups", sa.Text, nullable=False),
    )
