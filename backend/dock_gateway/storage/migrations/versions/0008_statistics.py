"""How goals ended: indexes for the statistics, and for goals by error code."""

import sqlalchemy as sa
from alembic import op

from dock_gateway.storage.rows import MAX_CODE

revision = "0008"
down_revision = "0007"
branch_labels = None
depends_on = None

goals = sa.table("goals", sa.column("error_code", sa.Text))


def upgrade() -> None:
    """Make the indexes. An error code of an earlier version may be too long for them."""
    code = goals.c.error_code
    shorter = sa.update(goals).where(sa.func.length(code) > MAX_CODE)
    op.execute(shorter.values(error_code=sa.func.substr(code, 1, MAX_CODE)))
    part = sa.text("error_code IS NOT NULL")
    op.create_index(
        "goals_by_error",
        "goals",
        ["error_code", "created_at", "goal_id"],
        sqlite_where=part,
        postgresql_where=part,
    )
    columns = ["created_at", "action_name", "status", "error_code", "retries", "finished_at"]
    op.create_index("goals_by_end", "goals", columns)
