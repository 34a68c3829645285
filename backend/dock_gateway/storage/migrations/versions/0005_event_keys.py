"""Events are stored once whoever saw them: a key says what happened."""

import sqlalchemy as sa
from alembic import op

from dock_gateway.storage.tables import identity

revision = "0005"
down_revision = "0004"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Add the key; events of before have none."""
    op.add_column("events", sa.Column("key", identity()))
    op.create_index("events_by_key", "events", ["key"], unique=True)
