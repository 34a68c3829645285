"""`/battery`: read the latest battery state, or publish one in place of a robot's battery driver."""

from fastapi import APIRouter, Depends, Request
from starlette.responses import Response

from dock_gateway.core.errors import FieldError, InvalidField, got
from dock_gateway.core.goal import fragment
from dock_gateway.core.grant import Role
from dock_gateway.http.openapi import battery_body, body
from dock_gateway.http.operation import Scope, operation
from dock_gateway.http.parts import Part
from dock_gateway.http.principal import TheGrant
from dock_gateway.http.problems import problems
from dock_gateway.http.requests import RobotQuery, json_response, known_query, read_json, read_object
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway.robots.schema import BatteryAnswer, Published, Publisher

router = APIRouter(tags=["Battery"], dependencies=[Depends(known_query("robot"))])

MIN_RATE, MAX_RATE, USUAL_RATE = 0.1, 100.0, 1.0
# Topics with batteries that are named, if that of a robot has none.
MAX_TOPICS = 20
PUBLISHER_REQUEST = {
    "type": "object",
    "required": ["state"],
    "additionalProperties": False,
    "properties": {
        "state": {"$ref": "#/components/schemas/BatteryStateInput"},
        "rate_hz": {
            "type": "number",
            "minimum": MIN_RATE,
            "maximum": MAX_RATE,
            "description": f"{USUAL_RATE:g} by default",
        },
    },
}


def read_rate(value: object) -> float:
    """Return a publishing rate, in messages per second.

    Raises:
        InvalidField: The value is not a number in range.
    """
    if not isinstance(value, int | float) or isinstance(value, bool) or not MIN_RATE <= value <= MAX_RATE:
        expected = f"a number from {MIN_RATE:g} to {MAX_RATE:g}"
        raise InvalidField([FieldError("rate_hz", expected, got(value))])
    return float(value)


@router.get("/battery", response_model=BatteryAnswer, responses=problems(404, 422, 503))
@operation(Role.VIEWER, Scope.ROBOT)
async def get_battery(robots: Part[RobotRegistry], grant: TheGrant, robot: RobotQuery = None) -> Response:
    """Return the latest battery state, its age, whether it is stale, and without one which batteries there are."""
    known = robots.get(robot)
    others = [topic for topic in await robots.other_batteries(known) if grant.covers_topic(topic)]
    return json_response({**known.battery.document(), "other_topics": others[:MAX_TOPICS]})


@router.post(
    "/battery",
    response_model=Published,
    responses=problems(400, 404, 409, 413, 415, 422, 503),
    openapi_extra=battery_body(required=True),
)
@operation(Role.SUPERVISOR, Scope.ROBOT)
async def publish_battery(request: Request, robots: Part[RobotRegistry], robot: RobotQuery = None) -> Response:
    """Publish one battery state. Omitted float fields are NaN."""
    state = await robots.get(robot).publisher.publish(await read_json(request))
    return json_response({"state": fragment(state)})


@router.get("/battery/publisher", response_model=Publisher, responses=problems(404, 422))
@operation(Role.VIEWER, Scope.ROBOT)
async def get_publisher(robots: Part[RobotRegistry], robot: RobotQuery = None) -> Response:
    """Return what the gateway publishes repeatedly."""
    return json_response(robots.get(robot).publisher.document())


@router.put(
    "/battery/publisher",
    response_model=Publisher,
    responses=problems(400, 404, 409, 413, 415, 422, 503),
    openapi_extra=body(PUBLISHER_REQUEST, required=True),
)
@operation(Role.SUPERVISOR, Scope.ROBOT)
async def start_publisher(request: Request, robots: Part[RobotRegistry], robot: RobotQuery = None) -> Response:
    """Start publishing a battery state repeatedly. Replaces what was published before."""
    fields = read_object(await read_json(request), "state", "rate_hz")
    if "state" not in fields:
        raise InvalidField([FieldError("state", "an object, {} for the defaults", "got none")])
    rate_hz = read_rate(fields.get("rate_hz", USUAL_RATE))
    await robots.get(robot).publisher.start(fields["state"], rate_hz)
    return json_response(robots.get(robot).publisher.document())


@router.delete("/battery/publisher", status_code=204, responses=problems(404, 422))
@operation(Role.SUPERVISOR, Scope.ROBOT)
async def stop_publisher(robots: Part[RobotRegistry], robot: RobotQuery = None) -> Response:
    """Stop publishing."""
    await robots.get(robot).publisher.stop()
    return Response(status_code=204)
