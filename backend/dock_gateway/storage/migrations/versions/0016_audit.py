"""The audit log, and the ends of its chain."""

import sqlalchemy as sa
from alembic import op

revision = "0016"
down_revision = "0015"
branch_labels = None
depends_on = None

GENESIS = "0" * 64


def upgrade() -> None:
    """Make the tables, and begin the chain."""
    op.create_table(
        "audit",
        sa.Column("sequence", sa.BigInteger, primary_key=True, autoincrement=False),
        sa.Column("entry_id", sa.Text, nullable=False),
        sa.Column("at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("principal", sa.Text),
        sa.Column("role", sa.Text),
        sa.Column("token_id", sa.Text),
        sa.Column("client", sa.Text),
        sa.Column("request_id", sa.Text),
        sa.Column("what", sa.Text, nullable=False),
        sa.Column("robot", sa.Text),
        sa.Column("action_name", sa.Text),
        sa.Column("goal_id", sa.Text),
        sa.Column("subject", sa.Text),
        sa.Column("status", sa.Integer, nullable=False),
        sa.Column("code", sa.Text),
        sa.Column("digest", sa.Text, nullable=False),
    )
    op.create_index("audit_by_entry", "audit", ["entry_id"], unique=True)
    op.create_index("audit_by_principal", "audit", ["principal", "sequence"])
    op.create_index("audit_by_what", "audit", ["what", "sequence"])
    op.create_index("audit_by_goal", "audit", ["goal_id", "sequence"])
    chain = op.create_table(
        "audit_chain",
        sa.Column("chain_id", sa.Integer, primary_key=True, autoincrement=False),
        sa.Column("anchor_sequence", sa.BigInteger, nullable=False),
        sa.Column("anchor_digest", sa.Text, nullable=False),
        sa.Column("head_sequence", sa.BigInteger, nullable=False),
        sa.Column("head_digest", sa.Text, nullable=False),
    )
    op.bulk_insert(
        chain,
        [
            {
                "chain_id": 1,
                "anchor_sequence": 0,
                "anchor_digest": GENESIS,
                "head_sequence": 0,
                "head_digest": GENESIS,
            }
        ],
    )
