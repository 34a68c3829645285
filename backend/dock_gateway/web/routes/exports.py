"""Downloads: a list of goals, or one goal with its events. CSV for spreadsheets, JSON for programs."""

import asyncio
from collections.abc import AsyncGenerator
from contextlib import aclosing
from typing import Annotated, Literal

from fastapi import APIRouter, Depends, Query, Request
from starlette.responses import Response

from dock_gateway.core.event import FEEDBACK, STORED_KINDS, Event, utc_now
from dock_gateway.core.goal import Goal, encode
from dock_gateway.gateway import Gateway
from dock_gateway.history import GoalFilter
from dock_gateway.history.protocol import NEVER
from dock_gateway.web.access import principal_of
from dock_gateway.web.problems import problems
from dock_gateway.web.queries import QUERY, GoalFilterQuery
from dock_gateway.web.requests import GoalId, TheGateway, get_gateway, known_query
from dock_gateway.web.routes.goals import with_tags
from dock_gateway.web.routes.sheets import GOAL_COLUMNS, FeedbackSheet, goal_row, rows_of
from dock_gateway.web.schemas.goals import ExportedGoal, TaggedGoal
from dock_gateway.web.slow_clients import PacedResponse

router = APIRouter(tags=["Goals"], prefix="/goals")

# Goals and events fetched per query, small enough that other requests do not wait long.
GOALS, EVENTS = 200, 500

Format = Literal["csv", "json"]
FormatQuery = Annotated[Format, Query(description="`csv` for spreadsheets, `json` for programs")]
MEDIA_TYPES = {"csv": "text/csv; charset=utf-8", "json": "application/json"}
CSV = {"text/csv": {"schema": {"type": "string"}}}


@router.get(
    "/export",
    response_model=list[TaggedGoal],
    responses={200: {"description": "A file", "content": CSV}, **problems(422, 429, 503)},
    dependencies=[Depends(known_query(*QUERY, "format"))],
)
async def export_goals(
    request: Request,
    gateway: TheGateway,
    wanted: GoalFilterQuery,
    format: FormatQuery = "json",  # noqa: A002
) -> Response:
    """Download all matching goals, newest first.

    CSV has one row per goal, with its goal and result messages as JSON. JSON is one array.
    """
    chunks = goals_as_csv(gateway, wanted) if format == "csv" else goals_as_json(gateway, wanted)
    return await download(request, chunks, f"goals-{utc_now():%Y%m%dT%H%M%SZ}", format)


@router.get(
    "/{goal_id}/export",
    response_model=ExportedGoal,
    responses={200: {"description": "A file", "content": CSV}, **problems(404, 422, 429, 503)},
    dependencies=[Depends(known_query("format"))],
)
async def export_goal(
    request: Request,
    goal_id: GoalId,
    gateway: TheGateway,
    format: FormatQuery = "json",  # noqa: A002
) -> Response:
    """Download one goal.

    CSV has its feedback: one row per event, one column per field. JSON has the goal with its events.
    """
    goal = await gateway.goal(goal_id)
    chunks = goal_as_csv(gateway, goal) if format == "csv" else goal_as_json(gateway, goal)
    return await download(request, chunks, f"goal-{goal_id}", format)


async def download(request: Request, chunks: AsyncGenerator[bytes], name: str, kind: Format) -> Response:
    """Return a file as a stream, which ends with the login.

    An error before the first piece becomes an error response.
    """
    gateway, principal = get_gateway(request), principal_of(request)

    async def counted() -> AsyncGenerator[bytes]:
        async with aclosing(chunks):
            with gateway.quotas.hold(principal, "exports"):
                async for chunk in chunks:
                    gateway.logins.require_valid(principal)
                    yield chunk

    held = counted()
    first = await anext(held)
    headers = {"Content-Disposition": f'attachment; filename="{name}.{kind}"'}
    timeout = gateway.settings.subscriber_timeout
    return PacedResponse(first, held, timeout, media_type=MEDIA_TYPES[kind], headers=headers)


async def goals_as_csv(gateway: Gateway, wanted: GoalFilter) -> AsyncGenerator[bytes]:
    """Yield a header row, then one row per goal."""
    head: list[list[object]] = [[*GOAL_COLUMNS]]
    async for goals in pages(gateway, wanted):
        tags = await gateway.history.notes.tags_of([goal.goal_id for goal in goals])
        yield rows_of([*head, *(goal_row(goal, tags.get(goal.goal_id, ())) for goal in goals)])
        head = []


async def goals_as_json(gateway: Gateway, wanted: GoalFilter) -> AsyncGenerator[bytes]:
    """Yield one JSON array with one line per goal."""
    before = b"[\n"
    async for goals in pages(gateway, wanted):
        if goals:
            yield before + b",\n".join(map(encode, await with_tags(gateway, goals)))
            before = b",\n"
    yield b"\n]\n" if before == b",\n" else b"[]\n"


async def goal_as_csv(gateway: Gateway, goal: Goal) -> AsyncGenerator[bytes]:
    """Yield a header row, then one row per feedback event."""
    sheet = FeedbackSheet()
    last = ""
    async for events in pieces(gateway, goal.goal_id, {FEEDBACK}):
        await asyncio.to_thread(sheet.look_at, [event.data for event in events])
        last = events[-1].id or last
    yield sheet.head()
    async for events in pieces(gateway, goal.goal_id, {FEEDBACK}, until=last):
        yield await asyncio.to_thread(sheet.rows, [event.data for event in events])


async def goal_as_json(gateway: Gateway, goal: Goal) -> AsyncGenerator[bytes]:
    """Yield the goal with its tags, notes and `events`, and whether these are `complete`."""
    notes = await gateway.history.notes.of(goal.goal_id)
    complete = await gateway.history.knows_all_of(goal)
    before = encode(goal.document() | vars(notes) | {"complete": complete})[:-1] + b',"events":[\n'
    async for events in pieces(gateway, goal.goal_id, set(STORED_KINDS.values())):
        yield before + b",\n".join(event.data for event in events)
        before = b",\n"
    yield b"\n]}\n" if before == b",\n" else before + b"]}\n"


async def pages(gateway: Gateway, wanted: GoalFilter) -> AsyncGenerator[list[Goal]]:
    """Yield the matching goals page by page. The first page may be empty."""
    goals, cursor = await gateway.page(wanted, GOALS)
    yield goals
    while cursor is not None:
        goals, cursor = await gateway.page(wanted, GOALS, cursor)
        yield goals


async def pieces(gateway: Gateway, goal_id: str, kinds: set[str], *, until: str = NEVER) -> AsyncGenerator[list[Event]]:
    """Yield the events of a goal in non-empty pieces."""
    after = ""
    while events := await gateway.history.events_of(goal_id, kinds=kinds, after=after, until=until, limit=EVENTS):
        yield events
        after = events[-1].id or ""
        if len(events) < EVENTS:
            return
