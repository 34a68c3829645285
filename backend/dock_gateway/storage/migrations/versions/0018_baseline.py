"""The tables of the first release. `migrate.py` makes those of a new database from `tables.py`."""

revision = "0018"
down_revision = None
branch_labels = None
depends_on = None


def upgrade() -> None:
    """There is nothing to do: a database has these tables, or is new."""
