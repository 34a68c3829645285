"""`/goals/{goal_id}/cancel`: cancels a goal on any action."""

from fastapi import APIRouter
from starlette.responses import Response

from dock_gateway.core.grant import Role
from dock_gateway.goals.canceling import request_cancel
from dock_gateway.goals.goals import Goals
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.goals.schema import ActionGoal
from dock_gateway.http.operation import Scope, operation
from dock_gateway.http.parts import Part
from dock_gateway.http.problems import problems
from dock_gateway.http.requests import NO_QUERY, GoalId, goal_response

router = APIRouter(tags=["Goals"], prefix="/goals")


@router.post(
    "/{goal_id}/cancel",
    status_code=202,
    response_model=ActionGoal,
    responses=problems(404, 409, 422, 503, 504),
    dependencies=[NO_QUERY],
)
@operation(Role.AGENT, Scope.GOAL)
async def cancel_any_goal(goal_id: GoalId, goals: Part[Goals], actions: Part[ActionRegistry]) -> Response:
    """Ask the action server to cancel a goal, on any action, whoever sent it."""
    return goal_response(await request_cancel(goals, actions, goal_id), f"/goals/{goal_id}", 202)
