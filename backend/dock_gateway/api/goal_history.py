"""`/goals/{goal_id}/history`: what has happened to a goal, event by event."""

from typing import Annotated, Literal

import orjson
from fastapi import APIRouter, Depends, Query
from starlette.responses import Response

from dock_gateway.api.answers import GoalId, TheGateway, json_response
from dock_gateway.api.goal_schemas import GoalHistory
from dock_gateway.api.interests import EVENT_ID
from dock_gateway.api.problems import problems
from dock_gateway.api.requests import known_query
from dock_gateway.events import KINDS

router = APIRouter(tags=["Goals"])

TypeQuery = Annotated[
    list[Literal["status", "feedback", "result"]] | None, Query(description="Only events of these types")
]
AfterQuery = Annotated[
    str | None, Query(pattern=f"^{EVENT_ID.pattern}$", description="Id of the event that they follow")
]


@router.get(
    "/goals/{goal_id}/history",
    response_model=GoalHistory,
    responses=problems(404, 422, 503),
    dependencies=[Depends(known_query("type", "after", "limit"))],
)
async def goal_history(
    goal_id: GoalId,
    gateway: TheGateway,
    *,
    type: TypeQuery = None,  # noqa: A002 - it is what the events call it
    after: AfterQuery = None,
    limit: Annotated[int, Query(ge=1, le=5000)] = 1000,
) -> Response:
    """The events of a goal, as they were sent on the streams, oldest first."""
    goal = await gateway.goal(goal_id)
    kinds = frozenset(KINDS[name] for name in type or KINDS)
    complete = await gateway.history.knows_all_of(goal)
    events = await gateway.history.events_of(goal_id, kinds=kinds, after=after or "", limit=limit + 1)
    page = events[:limit]
    return json_response(
        {
            "events": [orjson.Fragment(event.data) for event in page],
            "next_after": page[-1].id if len(events) > limit else None,
            "complete": complete,
        }
    )
