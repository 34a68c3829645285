"""When the history began: a reader that resumes after that has missed nothing that is older than all that is kept."""

import time

import sqlalchemy as sa
from alembic import op

from dock_gateway.core.event import time_id
from dock_gateway.storage.tables import BEGINNING

revision = "0007"
down_revision = "0006"
branch_labels = None
depends_on = None

horizons = sa.table("horizons", sa.column("topic"), sa.column("event_id"))


def upgrade() -> None:
    """Note it."""
    op.execute(sa.insert(horizons).values(topic=BEGINNING, event_id=time_id(time.time_ns())))
