"""`/goals`: the goals of every action, also of those that have left the graph."""

from fastapi import APIRouter, Depends
from starlette.responses import Response

from dock_gateway.api import goals
from dock_gateway.api.answers import CursorQuery, GoalId, LimitQuery, TheGateway, goal_response
from dock_gateway.api.problems import problems
from dock_gateway.api.requests import known_query
from dock_gateway.api.schemas import ActionGoal, ActionGoalPage
from dock_gateway.api.wanted import QUERY, WantedQuery

router = APIRouter(tags=["Goals"], prefix="/goals")

NO_QUERY = Depends(known_query())


@router.get(
    "",
    response_model=ActionGoalPage,
    responses=problems(422, 503),
    dependencies=[Depends(known_query(*QUERY, "limit", "cursor"))],
)
async def list_all_goals(
    gateway: TheGateway, wanted: WantedQuery, limit: LimitQuery = 50, cursor: CursorQuery = None
) -> Response:
    """Goals of every action, newest first."""
    return await goals.list_goals(gateway, wanted, limit, cursor)


@router.get("/{goal_id}", response_model=ActionGoal, responses=problems(404, 422, 503), dependencies=[NO_QUERY])
async def get_any_goal(goal_id: GoalId, gateway: TheGateway) -> Response:
    """One goal, on any action."""
    return goal_response(await gateway.goal(goal_id), f"/goals/{goal_id}")


@router.post(
    "/{goal_id}/cancel",
    status_code=202,
    response_model=ActionGoal,
    responses=problems(404, 409, 422, 503, 504),
    dependencies=[NO_QUERY],
)
async def cancel_any_goal(goal_id: GoalId, gateway: TheGateway) -> Response:
    """Ask the action server to cancel a goal, on any action and whoever sent it."""
    return goal_response(await gateway.cancel(goal_id), f"/goals/{goal_id}", 202)
