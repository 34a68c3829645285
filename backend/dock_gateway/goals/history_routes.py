"""`/goals`: the goals of every action."""

from typing import Annotated, Literal

import orjson
from fastapi import APIRouter, Query

from dock_gateway.core.event import KINDS, STORED_KINDS
from dock_gateway.core.grant import Role
from dock_gateway.goals.goals import Goals
from dock_gateway.goals.queries import GoalFilterQuery
from dock_gateway.goals.schema import ActionGoal, GoalHistory, TaggedGoalPage
from dock_gateway.http.operation import Audit, Scope, operation
from dock_gateway.http.parts import Part
from dock_gateway.http.queries import EVENT_ID
from dock_gateway.http.requests import Answer, CursorQuery, GoalId, LimitQuery, goal_response, json_response
from dock_gateway.http.route import ApiRoute
from dock_gateway.storage import History

router = APIRouter(route_class=ApiRoute, tags=["Goals"], prefix="/goals")


@router.get("")
@operation(Role.VIEWER, Scope.LISTED, Audit.NEVER)
async def list_all_goals(
    goals: Part[Goals], wanted: GoalFilterQuery, limit: LimitQuery = 50, cursor: CursorQuery = None
) -> Answer[TaggedGoalPage]:
    """List the goals of all actions with their tags, newest first."""
    page, next_cursor = await goals.page(wanted, limit, str(cursor) if cursor else None)
    return json_response({"goals": await goals.with_tags(page), "next_cursor": next_cursor})


@router.get("/{goal_id}")
@operation(Role.VIEWER, Scope.GOAL)
async def get_any_goal(goal_id: GoalId, goals: Part[Goals]) -> Answer[ActionGoal]:
    """Return one goal, on any action."""
    return goal_response(await goals.get(goal_id), f"/goals/{goal_id}")


TypeQuery = Annotated[
    list[Literal["status", "feedback", "result", "pose"]] | None,
    Query(description="Only events of these types; by default all but `pose`"),
]
AfterQuery = Annotated[
    str | None, Query(pattern=f"^{EVENT_ID.pattern}$", description="Id of the event that they follow")
]


@router.get("/{goal_id}/history")
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
