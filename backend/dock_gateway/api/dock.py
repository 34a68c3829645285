"""`/dock`: goals on the docking action of a robot."""

from fastapi import APIRouter, Depends, Request
from sensor_msgs.msg import BatteryState
from starlette.responses import Response

from dock_gateway.api import goals
from dock_gateway.api.answers import (
    CursorQuery,
    GoalId,
    LimitQuery,
    RobotQuery,
    StatusQuery,
    TheGateway,
    goal_response,
)
from dock_gateway.api.openapi import battery_body
from dock_gateway.api.problems import problems
from dock_gateway.api.requests import known_query
from dock_gateway.api.schemas import Goal, GoalPage

router = APIRouter(tags=["Dock"])

CHARGING = {"desired_battery_state": {"power_supply_status": BatteryState.POWER_SUPPLY_STATUS_CHARGING}}
ROBOT = Depends(known_query("robot"))


@router.post(
    "/dock",
    status_code=202,
    response_model=Goal,
    responses={
        200: {"model": Goal, "description": "It ended"},
        **problems(400, 404, 409, 413, 415, 422, 429, 503, 504),
    },
    openapi_extra={**battery_body(required=False, wrapped="desired_battery_state"), "parameters": goals.HEADERS},
    dependencies=[ROBOT],
)
async def dock(request: Request, gateway: TheGateway, robot: RobotQuery = None) -> Response:
    """Send the robot to its charging dock.

    An empty body asks for CHARGING. `Prefer: wait=30` waits for the end. `Idempotency-Key` makes a retry return the
    first goal.
    """
    return await goals.send_goal(request, await gateway.dock_of(robot), "/dock", CHARGING)


@router.get(
    "/dock",
    response_model=GoalPage,
    responses=problems(404, 422),
    dependencies=[Depends(known_query("robot", "status", "limit", "cursor"))],
)
async def list_goals(
    gateway: TheGateway,
    robot: RobotQuery = None,
    status: StatusQuery = None,
    limit: LimitQuery = 50,
    cursor: CursorQuery = None,
) -> Response:
    """Goals, newest first."""
    return await goals.list_goals(await gateway.dock_of(robot), status, limit, cursor)


@router.get("/dock/{goal_id}", response_model=Goal, responses=problems(404, 422))
async def get_goal(goal_id: GoalId, gateway: TheGateway) -> Response:
    """One goal, of any robot."""
    return goal_response(await gateway.goal(goal_id), f"/dock/{goal_id}")


@router.post(
    "/dock/{goal_id}/cancel", status_code=202, response_model=Goal, responses=problems(404, 409, 422, 503, 504)
)
async def cancel_goal(goal_id: GoalId, gateway: TheGateway) -> Response:
    """Ask the action server to cancel a goal, whoever sent it."""
    goal = await gateway.goal(goal_id)
    action = await gateway.actions.find(goal.action_name)
    return goal_response(await action.goals.cancel(goal_id), f"/dock/{goal_id}", 202)
