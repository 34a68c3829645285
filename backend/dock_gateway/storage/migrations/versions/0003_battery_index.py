"""Battery events by robot and time."""

import sqlalchemy as sa
from alembic import op

revision = "0003"
down_revision = "0002"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Make the index."""
    battery = sa.text("topic = 'battery'")
    op.create_index("battery_events", "events", ["robot", "id"], sqlite_where=battery, postgresql_where=battery)
