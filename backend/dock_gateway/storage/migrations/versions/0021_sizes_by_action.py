"""The size of the history is known by action, for the share of each site of a hub."""

from alembic import op

from dock_gateway.storage.tables import IS_KEPT

revision = "0021"
down_revision = "0020"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Make the index again, with the action."""
    op.drop_index("kept_events", "events")
    columns = ["action_name", "size", "droppable"]
    op.create_index("kept_events", "events", columns, sqlite_where=IS_KEPT, postgresql_where=IS_KEPT)
