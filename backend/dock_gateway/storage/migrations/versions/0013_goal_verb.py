"""Which of a robot's two docking actions a goal is on."""

import sqlalchemy as sa
from alembic import op

revision = "0013"
down_revision = "0012"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Add the column. It stays empty for earlier goals, see `rows.py`: to fill it would rewrite every goal."""
    op.add_column("goals", sa.Column("verb", sa.Text))
