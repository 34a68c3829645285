"""Users, tokens, sessions, labels, acknowledgements, decisions and deliveries become documents."""

from typing import Any

import orjson
import sqlalchemy as sa
from alembic import op

from dock_gateway.storage.column_types import JsonText, Names, UtcTime

revision = "0020"
down_revision = "0019"
branch_labels = None
depends_on = None

# Of each table: the kind of its documents, and its columns. The first is the key, the others are the fields.
TABLES = {
    "acknowledgements": ("acknowledgement", "alert_id name acknowledged_at"),
    "robot_labels": ("label", "robot display_name groups"),
    "automation_decisions": (
        "decision",
        """
        decision_id rule_id rule_name robot decided_at outcome battery idle_since scheduled_for goal_id code detail
        open
        """,
    ),
    "webhook_deliveries": (
        "delivery",
        """
        delivery_id webhook_id event_type state alert_id happened_at body attempts next_at tried_at status_code error
        """,
    ),
    "tokens": ("token", "token_id name role robots actions topics digest created_by created_at expires_at used_at"),
    "users": (
        "user",
        "name role robots actions topics password era disabled created_by created_at logged_in_at",
    ),
    "sessions": ("session", "session_id user_name era digest created_at expires_at used_at"),
    "person_sessions": (
        "person_session",
        "session_id person issuer subject role robots actions topics digest attempt created_at expires_at used_at",
    ),
}
# Columns whose field has another name.
FIELDS = {"acknowledged_at": "at", "decided_at": "at", "happened_at": "at", "user_name": "user", "person": "user"}
TIMES = ("idle_since", "scheduled_for")  # and what ends in `_at`
LISTS = ("robots", "actions", "topics", "groups")
FLAGS = ("open", "disabled")


def upgrade() -> None:
    """Move the rows of all these tables to that of the documents."""
    documents = sa.table("documents", sa.column("kind"), sa.column("key"), sa.column("document", JsonText))
    for table, (kind, names) in TABLES.items():
        columns = [sa.column(name, _type_of(name)) for name in names.split()]
        for key, *values in op.get_bind().execute(sa.select(*columns).select_from(sa.table(table))).all():
            fields = {_field_of(table, column.name): value for column, value in zip(columns[1:], values, strict=True)}
            op.bulk_insert(documents, [{"kind": kind, "key": key, "document": orjson.dumps(fields)}])
        op.drop_table(table)


def _field_of(table: str, column: str) -> str:
    return "by" if (table, column) == ("acknowledgements", "name") else FIELDS.get(column, column)


def _type_of(column: str) -> "sa.types.TypeEngine[Any] | None":
    if column.endswith("_at") or column in TIMES:
        return UtcTime()
    if column in LISTS:
        return Names()
    return sa.Boolean() if column in FLAGS else None
