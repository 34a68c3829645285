"""`/audit`: who did what, from where, to which robot, with which outcome."""

from collections.abc import AsyncGenerator
from functools import partial
from typing import Annotated

from fastapi import APIRouter, Depends, Query, Request
from pydantic import StringConstraints
from starlette.responses import Response

from dock_gateway.core.audit import AuditFilter, AuditRow, RequestOutcome
from dock_gateway.core.event import utc_now
from dock_gateway.core.goal import encode
from dock_gateway.core.grant import Role
from dock_gateway.core.namespace import read_namespace
from dock_gateway.extensions.audit_log.schema import AuditPage, AuditRecord
from dock_gateway.goals.known_robots import KnownRobots
from dock_gateway.http.downloads import CSV, FormatQuery, download
from dock_gateway.http.operation import Audit, Scope, operation
from dock_gateway.http.parts import Part
from dock_gateway.http.principal import TheGrant
from dock_gateway.http.queries import SinceQuery, UntilQuery, require_span
from dock_gateway.http.requests import GOAL_ID, Answer, AnyRobotQuery, LimitQuery, json_response, read_goal_id
from dock_gateway.http.route import ApiRoute
from dock_gateway.http.sheets import rows_of
from dock_gateway.storage import History

router = APIRouter(route_class=ApiRoute, tags=["Access"], prefix="/audit")

ROWS = 500  # per query of an export
SequenceCursor = Annotated[
    str | None, Query(pattern=r"^[1-9][0-9]{0,17}$", description="`next_cursor` of the previous page")
]
Text = Annotated[str, StringConstraints(min_length=1, max_length=100, pattern=r"^[^\x00]*$")]


async def read_audit_filter(
    *,
    history: Part[History],
    known_robots: Part[KnownRobots],
    grant: TheGrant,
    principal: Annotated[Text | None, Query(description="Only with the token of this name")] = None,
    what: Annotated[Text | None, Query(description="Only this operation, such as `release_stop`")] = None,
    robot: AnyRobotQuery = None,
    goal_id: Annotated[
        str | None,
        Query(description="Only about this goal", json_schema_extra={"pattern": f"^{GOAL_ID.pattern}$"}),
    ] = None,
    outcome: Annotated[RequestOutcome | None, Query(description="Only with this outcome")] = None,
    since: SinceQuery = None,
    until: UntilQuery = None,
) -> AuditFilter:
    """Return the filter of a query.

    Raises:
        InvalidField: A value is invalid.
        NotFound: There is and was no such robot, and no record is about it (`robot_not_found`).
    """
    require_span(since, until)
    namespace = None if robot is None else read_namespace(robot)

    async def has_record(name: str) -> bool:
        return bool(await history.audit.page(AuditFilter(robot=name), limit=1))

    await known_robots.require(robot, grant, has_record)
    return AuditFilter(
        principal,
        what,
        namespace,
        None if goal_id is None else read_goal_id(goal_id),
        outcome,
        since,
        until,
    )


AuditFilterQuery = Annotated[AuditFilter, Depends(read_audit_filter)]


@router.get("", name="list_audit")
@operation(Role.ADMIN, Scope.EVERY, Audit.ALWAYS, errors=(404,))
async def list_audit(
    history: Part[History],
    wanted: AuditFilterQuery,
    limit: LimitQuery = 50,
    cursor: SequenceCursor = None,
) -> Answer[AuditPage]:
    """List requests and commands, newest first: all that change something, exports, and reads of this list."""
    rows = await history.audit.page(wanted, limit=limit + 1, before=None if cursor is None else int(cursor))
    more = len(rows) > limit
    records = [row.document() for row in rows[:limit]]
    return json_response({"records": records, "next_cursor": str(rows[limit - 1].sequence) if more else None})


@router.get(
    "/export",
    name="export_audit",
    response_model=list[AuditRecord],
    responses={200: {"description": "A file", "content": CSV}},
)
@operation(Role.ADMIN, Scope.EVERY, Audit.ALWAYS, errors=(404, 429))
async def export_audit(
    request: Request,
    history: Part[History],
    wanted: AuditFilterQuery,
    format: FormatQuery = "json",  # noqa: A002
) -> Response:
    """Download all matching records, newest first."""
    chunks = _as_csv(history, wanted) if format == "csv" else _as_json(history, wanted)
    return await download(request, chunks, f"audit-{utc_now():%Y%m%dT%H%M%SZ}", format)


async def _as_csv(history: History, wanted: AuditFilter) -> AsyncGenerator[bytes]:
    head: list[list[object]] = [[*AuditRecord.model_fields]]
    async for rows in _pages(history, wanted):
        yield rows_of([*head, *(list(row.document().values()) for row in rows)])
        head = []


async def _as_json(history: History, wanted: AuditFilter) -> AsyncGenerator[bytes]:
    before = b"[\n"
    async for rows in _pages(history, wanted):
        if rows:
            yield before + b",\n".join(encode(row.document()) for row in rows)
            before = b",\n"
    yield b"\n]\n" if before == b",\n" else b"[]\n"


async def _pages(history: History, wanted: AuditFilter) -> AsyncGenerator[list[AuditRow]]:
    """Yield the matching rows page by page. The first page may be empty."""
    page = partial(history.audit.page, wanted, limit=ROWS)
    rows = await page()
    yield rows
    while len(rows) == ROWS and (rows := await page(before=rows[-1].sequence)):
        yield rows
