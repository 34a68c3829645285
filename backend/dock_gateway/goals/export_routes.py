"""Downloads: a list of goals, or one goal with its events. CSV for spreadsheets, JSON for programs."""

import asyncio
from collections.abc import AsyncGenerator
from typing import Annotated, Any

from fastapi import APIRouter, Query, Request
from starlette.responses import Response

from dock_gateway.core.event import FEEDBACK, NEVER, STORED_KINDS, Event, utc_now
from dock_gateway.core.goal import Goal, encode
from dock_gateway.core.grant import Grant, Role
from dock_gateway.goals.goal_documents import GoalDocuments
from dock_gateway.goals.goals import Goals
from dock_gateway.goals.queries import AnyGoalQuery
from dock_gateway.goals.schema import ExportedGoal
from dock_gateway.goals.schema import Goal as GoalAnswer
from dock_gateway.http.downloads import CSV, FormatQuery, download
from dock_gateway.http.operation import Audit, Scope, operation
from dock_gateway.http.parts import AllParts, Part
from dock_gateway.http.principal import TheGrant
from dock_gateway.http.requests import GoalId
from dock_gateway.http.route import ApiRoute
from dock_gateway.http.sheets import GOAL_COLUMNS, FeedbackSheet, goal_row, rows_of
from dock_gateway.storage import GoalFilter, History

router = APIRouter(route_class=ApiRoute, tags=["Goals"], prefix="/goals")

# Goals and events fetched per query, small enough that other requests do not wait long.
GOALS, EVENTS = 200, 500


@router.get("/export", response_model=list[GoalAnswer], responses={200: {"description": "A file", "content": CSV}})
@operation(Role.VIEWER, Scope.LISTED, Audit.ALWAYS, errors=(404, 429))
async def export_goals(
    request: Request,
    parts: AllParts,
    grant: TheGrant,
    query: Annotated[AnyGoalQuery, Query()],
    *,
    format: FormatQuery = "json",  # noqa: A002
) -> Response:
    """Download all matching goals, newest first.

    CSV has one row per goal, with its goal and result messages as JSON. JSON is one array.
    """
    wanted = await query.to_filter(parts, grant)
    if format == "csv":
        chunks = goals_as_csv(parts[Goals], parts[History], wanted)
    else:
        chunks = goals_as_json(parts[Goals], parts[GoalDocuments], grant, wanted)
    return await download(request, chunks, f"goals-{utc_now():%Y%m%dT%H%M%SZ}", format)


@router.get(
    "/{goal_id}/export", response_model=ExportedGoal, responses={200: {"description": "A file", "content": CSV}}
)
@operation(Role.VIEWER, Scope.GOAL, Audit.ALWAYS, errors=(429,))
async def export_goal(
    request: Request,
    goal_id: GoalId,
    goals: Part[Goals],
    *,
    history: Part[History],
    documents: Part[GoalDocuments],
    grant: TheGrant,
    format: FormatQuery = "json",  # noqa: A002
) -> Response:
    """Download one goal.

    CSV has its feedback: one row per event, one column per field. JSON has the goal with its events.
    """
    goal = await goals.get(goal_id)
    if format == "csv":
        chunks = goal_as_csv(history, goal)
    else:
        (document,) = await documents.full([goal], grant)
        chunks = goal_as_json(history, goal, document)
    return await download(request, chunks, f"goal-{goal_id}", format)


async def goals_as_csv(all_goals: Goals, history: History, wanted: GoalFilter) -> AsyncGenerator[bytes]:
    """Yield a header row, then one row per goal."""
    head: list[list[object]] = [[*GOAL_COLUMNS]]
    async for goals in pages(all_goals, wanted):
        tags = await history.notes.tags_of([goal.goal_id for goal in goals])
        yield rows_of([*head, *(goal_row(goal, tags.get(goal.goal_id, ())) for goal in goals)])
        head = []


async def goals_as_json(
    all_goals: Goals, documents: GoalDocuments, grant: Grant, wanted: GoalFilter
) -> AsyncGenerator[bytes]:
    """Yield one JSON array with one line per goal."""
    before = b"[\n"
    async for goals in pages(all_goals, wanted):
        if goals:
            yield before + b",\n".join(map(encode, await documents.full(goals, grant)))
            before = b",\n"
    yield b"\n]\n" if before == b",\n" else b"[]\n"


async def goal_as_csv(history: History, goal: Goal) -> AsyncGenerator[bytes]:
    """Yield a header row, then one row per feedback event."""
    sheet = FeedbackSheet()
    last = ""
    async for events in pieces(history, goal.goal_id, {FEEDBACK}):
        await asyncio.to_thread(sheet.add_columns, [event.data for event in events])
        last = events[-1].id or last
    yield sheet.head()
    async for events in pieces(history, goal.goal_id, {FEEDBACK}, until=last):
        yield await asyncio.to_thread(sheet.rows, [event.data for event in events])


async def goal_as_json(history: History, goal: Goal, document: dict[str, Any]) -> AsyncGenerator[bytes]:
    """Yield the document of a goal with its `events`, and whether these are `complete`."""
    complete = await history.knows_all_of(goal)
    before = encode(document | {"complete": complete})[:-1] + b',"events":[\n'
    async for events in pieces(history, goal.goal_id, set(STORED_KINDS.values())):
        yield before + b",\n".join(event.data for event in events)
        before = b",\n"
    yield b"\n]}\n" if before == b",\n" else before + b"]}\n"


async def pages(all_goals: Goals, wanted: GoalFilter) -> AsyncGenerator[list[Goal]]:
    """Yield the matching goals page by page. The first page may be empty."""
    goals, end = await all_goals.page(wanted, GOALS)
    yield goals
    while end is not None:
        goals, end = await all_goals.page(wanted, GOALS, end)
        yield goals


async def pieces(history: History, goal_id: str, kinds: set[str], *, until: str = NEVER) -> AsyncGenerator[list[Event]]:
    """Yield the events of a goal in non-empty pieces."""
    after = ""
    while events := await history.events_of(goal_id, kinds=kinds, after=after, until=until, limit=EVENTS):
        yield events
        after = events[-1].id or ""
        if len(events) < EVENTS:
            return
