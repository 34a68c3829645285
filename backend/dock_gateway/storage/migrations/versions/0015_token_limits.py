"""The robots, actions and topics that a token is limited to."""

import sqlalchemy as sa
from alembic import op

revision = "0015"
down_revision = "0014"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Add the columns. Earlier tokens are not limited."""
    for name in ("robots", "actions", "topics"):
        op.add_column("tokens", sa.Column(name, sa.Text, nullable=False, server_default="[]"))
