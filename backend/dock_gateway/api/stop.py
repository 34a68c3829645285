"""`/stop`: stop a robot, see whether a stop is latched, release it."""

import logging
from typing import Any

from fastapi import APIRouter, Depends, Request
from starlette.responses import Response

from dock_gateway.api.answers import RobotQuery, TheGateway, json_response
from dock_gateway.api.openapi import body
from dock_gateway.api.problems import problems
from dock_gateway.api.requests import known_query, read_json, read_name, read_object, read_wait
from dock_gateway.api.schemas import StopReport, StopState
from dock_gateway.errors import FieldError, GatewayError, InvalidField, MalformedRequest
from dock_gateway.gateway import Gateway

log = logging.getLogger(__name__)

router = APIRouter(tags=["Stop"], dependencies=[Depends(known_query("robot"))])

FIELDS = ("latch", "by")
MAX_NAME = 100
# A stop waits no longer for its body, in seconds.
BODY_WITHIN = 1.0
STOP_REQUEST = {
    "type": "object",
    "additionalProperties": False,
    "properties": {
        "latch": {
            "type": "boolean",
            "description": "Whether goals are refused until the stop is released; true where it is left out",
        },
        "by": {"type": ["string", "null"], "maxLength": MAX_NAME, "description": "Who asks for the stop"},
    },
}
PREFER = [{"name": "Prefer", "in": "header", "schema": {"type": "string"}, "example": "wait=2"}]


async def stop_robot(
    gateway: Gateway, robot: str | None, value: object, *, wait: float = 0.0, problem: GatewayError | None = None
) -> dict[str, Any]:
    """Stop a robot in the way that is asked for; by the defaults, where that cannot be understood.

    Args:
        gateway: The gateway.
        robot: The robot; None is the configured one.
        value: The decoded body, or the fields of a command.
        wait: Seconds that action servers may take to answer.
        problem: What is known to be wrong with the request already.

    Returns:
        The report, with what was wrong as `warning`.

    Raises:
        NotFound: There is no such robot.
        Unavailable: The ROS thread is down.
    """
    how: dict[str, Any] = {}
    try:
        how = _read_stop(read_object(value, *FIELDS))
    except InvalidField as error:
        problem = error
    if problem is not None:
        log.warning("a stop is carried out, though it could not be understood as a whole: %s", problem.detail)
    report = await gateway.stopper.stop(robot, **how, wait=wait)
    return {**vars(report), "warning": problem and problem.problem()}


def _read_stop(fields: dict[str, Any]) -> dict[str, Any]:
    latch, by = fields.get("latch", True), fields.get("by")
    if not isinstance(latch, bool):
        raise InvalidField([FieldError("latch", "true or false", f"got {latch!r:.40}")])
    return {"latch": latch, "by": None if by is None else read_name(by, MAX_NAME)}


@router.post(
    "/stop",
    response_model=StopReport,
    responses=problems(404, 422, 503),
    openapi_extra={**body(STOP_REQUEST, required=False), "parameters": PREFER},
)
async def stop(request: Request, gateway: TheGateway, robot: RobotQuery = None) -> Response:
    """Publish zero velocity at once, cancel every goal on every action of the robot, and let none be sent any more.

    Goals of other clients are canceled, too. New ones are refused (`409 stop_latched`) until the stop is released by
    `DELETE /stop`; with `{"latch": false}` they are not. Robots in namespaces below are stopped, too: without
    `robot`, on a gateway without a namespace, all of them. The answer comes within 100 ms: an action server that has
    not answered by then is in `unconfirmed`. `Prefer: wait=2` waits for it that long. A body that cannot be read keeps
    nobody from stopping: the robot is stopped as without one, and `warning` says what is wrong.
    """
    value: Any = {}
    wait, problem = 0.0, None
    try:
        value = await read_json(request, empty={}, within=BODY_WITHIN)
        wait = read_wait(request)
    except (MalformedRequest, InvalidField) as error:
        problem = error
    if isinstance(value, dict) and "robot" in value:  # the one at the address may be another
        raise InvalidField([FieldError("robot", "the robot in the query: /stop?robot=/robot1", "got it in the body")])
    return json_response(await stop_robot(gateway, robot, value, wait=wait, problem=problem))


@router.get("/stop", response_model=StopState, responses=problems(404, 422))
async def get_stop(gateway: TheGateway, robot: RobotQuery = None) -> Response:
    """Whether a stop is latched for a robot."""
    return json_response(gateway.stopper.state(robot))


@router.delete("/stop", response_model=StopState, responses=problems(404, 409, 422, 503))
async def release_stop(gateway: TheGateway, robot: RobotQuery = None) -> Response:
    """Release the stop of a robot and of those below it; also where none is latched. The robot stays where it is."""
    return json_response(await gateway.stopper.release(robot))
