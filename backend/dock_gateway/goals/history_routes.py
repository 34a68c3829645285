"""`/goals`: the goals of every action, sent by any client."""

from typing import Annotated, Any, Literal

import orjson
from fastapi import APIRouter, Query

from dock_gateway.core.event import KINDS, STORED_KINDS
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.grant import Grant, Role
from dock_gateway.goals.goal_documents import GoalDocuments
from dock_gateway.goals.goal_path import at_goal
from dock_gateway.goals.goals import Goals
from dock_gateway.goals.queries import AnyGoalQuery
from dock_gateway.goals.schema import Goal, GoalHistory, GoalPage
from dock_gateway.http.operation import Audit, Scope, operation
from dock_gateway.http.parts import AllParts, Part, Parts
from dock_gateway.http.principal import TheGrant
from dock_gateway.http.queries import EVENT_ID
from dock_gateway.http.requests import (
    WITH_POSITION,
    Answer,
    CursorQuery,
    GoalId,
    LimitQuery,
    end_of_page,
    json_response,
    list_response,
)
from dock_gateway.http.route import ApiRoute
from dock_gateway.storage import GoalFilter, History

router = APIRouter(route_class=ApiRoute, tags=["Goals"])


@router.get("/goals", responses=WITH_POSITION)
@operation(Role.VIEWER, Scope.LISTED, Audit.NEVER, errors=(404,))
async def list_goals(
    parts: AllParts,
    grant: TheGrant,
    query: Annotated[AnyGoalQuery, Query()],
    *,
    limit: LimitQuery = 50,
    cursor: CursorQuery = None,
) -> Answer[GoalPage]:
    """List the goals of all actions, newest first. A stream goes on after the header `Event-Id`."""
    return await answer_page(parts, grant, await query.to_filter(parts, grant), limit, cursor)


async def answer_page(parts: Parts, grant: Grant, wanted: GoalFilter, limit: int, cursor: str | None) -> Answer[Any]:
    """Answer with a page of goals, newest first."""
    position = parts[Fanout].position  # before the list
    page, end = await parts[Goals].page(wanted, limit, end_of_page(cursor))
    document = {"goals": await parts[GoalDocuments].full(page, grant), "next_cursor": end and end.encode()}
    return list_response(document, position)


@at_goal(router, "GET")
@operation(Role.VIEWER, Scope.GOAL)
async def get_goal(
    goal_id: GoalId, goals: Part[Goals], documents: Part[GoalDocuments], grant: TheGrant
) -> Answer[Goal]:
    """Return one goal, on any action."""
    (document,) = await documents.full([await goals.get(goal_id)], grant)
    return json_response(document)


TypeQuery = Annotated[
    list[Literal["status", "feedback", "result", "pose"]] | None,
    Query(description="Only events of these types; by default all but `pose`"),
]
AfterQuery = Annotated[
    str | None, Query(pattern=f"^{EVENT_ID.pattern}$", description="Id of the event that they follow")
]


@router.get("/goals/{goal_id}/history")
@operation(Role.VIEWER, Scope.GOAL)
async def goal_history(
    goal_id: GoalId,
    goals: Part[Goals],
    history: Part[History],
    *,
    type: TypeQuery = None,  # noqa: A002 - it is what the events call it
    after: AfterQuery = None,
    limit: Annotated[int, Query(ge=1, le=5000)] = 1000,
) -> Answer[GoalHistory]:
    """List the events of a goal as they were sent on the streams, oldest first; or the stored poses of its robot."""
    goal = await goals.get(goal_id)
    kinds = frozenset(STORED_KINDS[name] for name in type or KINDS)
    complete = await history.knows_all_of(goal)
    events = await history.events_of(goal_id, kinds=kinds, after=after or "", limit=limit + 1)
    page = events[:limit]
    return json_response(
        {
            "events": [orjson.Fragment(event.data) for event in page],
            "next_after": page[-1].id if len(events) > limit else None,
            "complete": complete,
        }
    )
