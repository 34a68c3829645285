"""Rules and webhooks become documents."""

from typing import Any

import orjson
import sqlalchemy as sa
from alembic import op

from dock_gateway.storage.column_types import JsonText, Names, UtcTime

revision = "0019"
down_revision = "0018"
branch_labels = None
depends_on = None

# The columns that both tables have.
SHARED = {"every_robot": sa.Boolean, "robots": Names, "groups": Names, "changed_by": sa.Text, "changed_at": UtcTime}


def upgrade() -> None:
    """Move the rows of two tables to the new one."""
    documents = op.create_table(
        "documents",
        sa.Column("kind", sa.Text, primary_key=True),
        sa.Column("key", sa.Text, primary_key=True),
        sa.Column("document", JsonText, nullable=False),
    )
    rules = sa.table(
        "automation_rules",
        *(sa.column(name, sa.Text) for name in ("rule_id", "name", "mode", "time_zone")),
        *(sa.column(name, sa.Float) for name in ("below", "idle_s")),
        *(sa.column(name, Names) for name in ("times", "weekdays")),
        *(sa.column(name, kind()) for name, kind in SHARED.items()),
    )
    webhooks = sa.table(
        "webhooks",
        *(sa.column(name, sa.Text) for name in ("webhook_id", "name", "url", "secret")),
        sa.column("enabled", sa.Boolean),
        sa.column("severities", Names),
        *(sa.column(name, kind()) for name, kind in SHARED.items()),
    )
    for row in op.get_bind().execute(sa.select(rules)).mappings().all():
        fields = _without_choice(row)
        below, idle_s = fields.pop("below"), fields.pop("idle_s")
        schedule = {name: fields.pop(name) for name in ("times", "weekdays", "time_zone")}
        fields["battery"] = None if below is None else {"below": below, "idle_s": idle_s}
        fields["schedule"] = schedule if below is None else None
        op.bulk_insert(documents, [_document("rule", fields.pop("rule_id"), fields)])
    for row in op.get_bind().execute(sa.select(webhooks)).mappings().all():
        fields = _without_choice(row)
        op.bulk_insert(documents, [_document("webhook", fields.pop("webhook_id"), fields)])
    op.drop_table("automation_rules")
    op.drop_table("webhooks")


def _without_choice(row: Any) -> dict[str, Any]:
    fields = dict(row)
    fields["robots"] = {"all": fields.pop("every_robot"), "names": fields.pop("robots"), "groups": fields.pop("groups")}
    return fields


def _document(kind: str, key: str, fields: dict[str, Any]) -> dict[str, Any]:
    return {"kind": kind, "key": key, "document": orjson.dumps(fields)}
