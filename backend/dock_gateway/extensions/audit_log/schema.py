"""The JSON shapes of the audit log."""

from datetime import datetime

from dock_gateway.core.audit import RequestOutcome
from dock_gateway.core.grant import Role
from dock_gateway.http.schema import Schema


class AuditRecord(Schema):
    """One request or command.

    `what` is the `operationId` of a request, or the `op` of a command of `/ws`. `principal`, `role` and `token_id` are
    null without a valid token. `robot` has several robots separated by commas. `digest` is the SHA-256 over the digest
    of the previous record and this one.
    """

    sequence: int
    id: str
    acted_at: datetime
    principal: str | None
    role: Role | None
    token_id: str | None
    client: str | None
    request_id: str | None
    what: str
    robot: str | None
    action_name: str | None
    goal_id: str | None
    subject: str | None
    status: int
    code: str | None
    outcome: RequestOutcome
    digest: str


class AuditPage(Schema):
    """A page of the audit log, newest first."""

    records: list[AuditRecord]
    next_cursor: str | None
