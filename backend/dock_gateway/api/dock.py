"""`/dock`: goals on the docking action, and `/stop`."""

import uuid
from typing import Annotated

from fastapi import APIRouter, Depends, Query, Request
from sensor_msgs.msg import BatteryState
from starlette.responses import Response

from dock_gateway.api.openapi import battery_body
from dock_gateway.api.problems import problems
from dock_gateway.api.requests import get_gateway, known_query, read_json, read_key, read_wait
from dock_gateway.api.schemas import Goal as GoalModel
from dock_gateway.api.schemas import GoalPage, StopReport
from dock_gateway.errors import FieldError, InvalidField
from dock_gateway.gateway import Gateway
from dock_gateway.goals import Goal, GoalStatus, encode

router = APIRouter(tags=["Dock"])

TheGateway = Annotated[Gateway, Depends(get_gateway)]
CHARGING = {"desired_battery_state": {"power_supply_status": BatteryState.POWER_SUPPLY_STATUS_CHARGING}}
HEADERS = [
    {"name": "Prefer", "in": "header", "schema": {"type": "string"}, "example": "wait=30"},
    {
        "name": "Idempotency-Key",
        "in": "header",
        "schema": {"type": "string", "minLength": 1, "maxLength": 200},
    },
]


def json_response(document: object, status: int = 200, headers: dict[str, str] | None = None) -> Response:
    """An answer in JSON, as the whole gateway writes it."""
    return Response(encode(document), status, headers, "application/json")


def goal_response(goal: Goal, status: int = 200) -> Response:
    """A goal, and where it is found from now on."""
    return json_response(goal.document(), status, {"Location": f"/dock/{goal.goal_id}"})


def read_goal_id(goal_id: str) -> str:
    """A goal id in its canonical form.

    Raises:
        InvalidField: It is not a UUID.
    """
    try:
        return str(uuid.UUID(goal_id))
    except ValueError:
        raise InvalidField([FieldError("goal_id", "a UUID", f"got {goal_id[:60]!r}")]) from None


GoalId = Annotated[str, Depends(read_goal_id)]


@router.post(
    "/dock",
    status_code=202,
    response_model=GoalModel,
    responses={
        200: {"model": GoalModel, "description": "It ended"},
        **problems(400, 409, 413, 415, 422, 429, 503, 504),
    },
    openapi_extra={**battery_body(required=False, wrapped="desired_battery_state"), "parameters": HEADERS},
    dependencies=[Depends(known_query())],
)
async def dock(request: Request, gateway: TheGateway) -> Response:
    """Send the robot to its charging dock.

    An empty body asks for CHARGING. `Prefer: wait=30` waits for the end. `Idempotency-Key` makes a retry return the
    first goal.
    """
    wait, key = read_wait(request), read_key(request)
    message = gateway.dock.goal_codec.parse(await read_json(request) or CHARGING)
    goal = await gateway.goals.submit(message, key)
    if wait:
        await gateway.goals.wait(goal, wait)
    return goal_response(goal, 200 if wait and goal.status.terminal else 202)


@router.get(
    "/dock",
    response_model=GoalPage,
    responses=problems(422),
    dependencies=[Depends(known_query("status", "limit", "cursor"))],
)
async def list_goals(
    gateway: TheGateway,
    status: Annotated[list[GoalStatus], Query()] = [],  # noqa: B006 - FastAPI copies it
    limit: Annotated[int, Query(ge=1, le=500)] = 50,
    cursor: Annotated[uuid.UUID | None, Query(description="`next_cursor` of the page before")] = None,
) -> Response:
    """Goals, newest first."""
    goals, next_cursor = await gateway.goals.page(frozenset(status), limit, str(cursor) if cursor else None)
    return json_response({"goals": [goal.document() for goal in goals], "next_cursor": next_cursor})


@router.get("/dock/{goal_id}", response_model=GoalModel, responses=problems(404, 422))
async def get_goal(goal_id: GoalId, gateway: TheGateway) -> Response:
    """One goal."""
    return goal_response(await gateway.goals.get(goal_id))


@router.post(
    "/dock/{goal_id}/cancel",
    status_code=202,
    response_model=GoalModel,
    responses=problems(404, 409, 422, 503, 504),
)
async def cancel_goal(goal_id: GoalId, gateway: TheGateway) -> Response:
    """Ask the action server to cancel a goal, whoever sent it."""
    return goal_response(await gateway.goals.cancel(goal_id), 202)


@router.post("/stop", response_model=StopReport, responses=problems(422, 503), dependencies=[Depends(known_query())])
async def stop(gateway: TheGateway) -> Response:
    """Publish zero velocity at once and cancel every goal on the action, other clients' too."""
    return json_response(await gateway.goals.stop())
