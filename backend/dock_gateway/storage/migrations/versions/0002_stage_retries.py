"""Stage and retries of a goal."""

import sqlalchemy as sa
from alembic import op

revision = "0002"
down_revision = "0001"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Add the columns; what was there before has neither."""
    op.add_column("goals", sa.Column("stage", sa.Text))
    op.add_column("goals", sa.Column("retries", sa.Integer))
