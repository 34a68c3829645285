"""`/stop`: stop a robot, see whether a stop is latched, release it."""

from typing import Any

from fastapi import APIRouter, Depends, Request
from starlette.responses import Response

from dock_gateway.api.answers import RobotQuery, TheGateway, json_response
from dock_gateway.api.openapi import body
from dock_gateway.api.problems import problems
from dock_gateway.api.requests import known_query, read_json, read_name, read_object, read_wait
from dock_gateway.api.schemas import StopReport, StopState
from dock_gateway.errors import FieldError, InvalidField

router = APIRouter(tags=["Stop"], dependencies=[Depends(known_query("robot"))])

FIELDS = ("latch", "by")
MAX_NAME = 100
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


def read_stop(fields: dict[str, Any]) -> dict[str, Any]:
    """How to stop: `latch` and `by`.

    Raises:
        InvalidField: One of them is wrong.
    """
    latch, by = fields.get("latch", True), fields.get("by")
    if not isinstance(latch, bool):
        raise InvalidField([FieldError("latch", "true or false", f"got {latch!r:.40}")])
    return {"latch": latch, "by": None if by is None else read_name(by, MAX_NAME)}


@router.post(
    "/stop",
    response_model=StopReport,
    responses=problems(400, 404, 408, 413, 415, 422, 503),
    openapi_extra={**body(STOP_REQUEST, required=False), "parameters": PREFER},
)
async def stop(request: Request, gateway: TheGateway, robot: RobotQuery = None) -> Response:
    """Publish zero velocity at once, cancel every goal on every action of the robot, and let none be sent any more.

    Goals of other clients are canceled, too. New ones are refused (`409 stop_latched`) until the stop is released by
    `DELETE /stop`; with `{"latch": false}` they are not. Robots in namespaces below are stopped, too: without
    `robot`, on a gateway without a namespace, all of them. The answer comes within 100 ms: an action server that has
    not answered by then is in `unconfirmed`. `Prefer: wait=2` waits for it that long.
    """
    wait = read_wait(request)
    fields = read_object(await read_json(request, empty={}), *FIELDS)
    return json_response(await gateway.stopper.stop(robot, **read_stop(fields), wait=wait))


@router.get("/stop", response_model=StopState, responses=problems(404, 422))
async def get_stop(gateway: TheGateway, robot: RobotQuery = None) -> Response:
    """Whether a stop is latched for a robot."""
    return json_response(gateway.stopper.state(robot))


@router.delete("/stop", response_model=StopState, responses=problems(404, 409, 422, 503))
async def release_stop(gateway: TheGateway, robot: RobotQuery = None) -> Response:
    """Release the stop of a robot and of those below it; also where none is latched. The robot stays where it is."""
    return json_response(await gateway.stopper.release(robot))
