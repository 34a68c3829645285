"""`/goals/{goal_id}/cancel`: cancels a goal on any action."""

from fastapi import APIRouter

from dock_gateway.goals.schema import ActionGoal
from dock_gateway.http.operation import carries_out
from dock_gateway.http.parts import AllParts
from dock_gateway.http.principal import ThePrincipal
from dock_gateway.http.requests import Answer, GoalId, goal_response
from dock_gateway.http.route import ApiRoute
from dock_gateway.operations.goals import CancelGoal, cancel_goal

router = APIRouter(route_class=ApiRoute, tags=["Goals"], prefix="/goals")


@router.post("/{goal_id}/cancel", status_code=202)
@carries_out(cancel_goal)
async def cancel_any_goal(goal_id: GoalId, parts: AllParts, principal: ThePrincipal) -> Answer[ActionGoal]:
    """Ask the action server to cancel a goal, on any action, whoever sent it."""
    goal = await cancel_goal(parts, principal, CancelGoal(goal_id))
    return goal_response(goal, f"/goals/{goal_id}", 202)
