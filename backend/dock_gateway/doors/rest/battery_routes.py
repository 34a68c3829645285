"""`/battery`: a robot's latest battery state, its past as points of a plot, and a stand-in for its battery driver."""

from datetime import datetime, timedelta
from typing import Annotated, Any

from fastapi import APIRouter, Query, Request
from starlette.responses import Response

from dock_gateway.core.errors import FieldError, InvalidField
from dock_gateway.core.event import moment, nanoseconds, utc_now
from dock_gateway.core.goal import fragment
from dock_gateway.core.grant import Role
from dock_gateway.core.namespace import read_namespace
from dock_gateway.goals.known_robots import KnownRobots
from dock_gateway.http.openapi import UNSTABLE, battery_body, body
from dock_gateway.http.operation import Scope, carries_out, operation
from dock_gateway.http.parts import AllParts, Part
from dock_gateway.http.principal import TheGrant, ThePrincipal
from dock_gateway.http.queries import SinceQuery, UntilQuery, require_span
from dock_gateway.http.requests import Answer, RobotQuery, json_response, read_json, read_object
from dock_gateway.http.route import ApiRoute
from dock_gateway.operations import battery as operations
from dock_gateway.operations.battery import MAX_RATE, MIN_RATE, USUAL_RATE
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway.robots.schema import BatteryAnswer, BatteryHistory, Published, Publisher
from dock_gateway.settings import Settings
from dock_gateway.storage import History
from dock_gateway.storage.battery import FIELDS, BatterySpan, Bucket

router = APIRouter(route_class=ApiRoute, tags=["Battery"])

DEFAULT_SPAN = timedelta(minutes=5)
MIN_STEP = 1_000  # nanoseconds; the API gives times in microseconds
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


@router.get("/battery")
@operation(Role.VIEWER, Scope.ROBOT, errors=(404,))
async def get_battery(robots: Part[RobotRegistry], grant: TheGrant, robot: RobotQuery = None) -> Answer[BatteryAnswer]:
    """Return the latest battery state, its age, whether it is stale, and without one which batteries there are."""
    known = robots.get(robot)
    others = [topic for topic in await robots.other_batteries(known) if grant.covers_topic(topic)]
    age = known.battery.age
    more = {"age_s": None if age is None else round(age, 3), "other_topics": others[:MAX_TOPICS]}
    return json_response(known.battery.document() | more)


@router.post("/battery", openapi_extra=battery_body(required=True))
@carries_out(operations.publish_battery)
async def publish_battery(
    request: Request, parts: AllParts, principal: ThePrincipal, robot: RobotQuery = None
) -> Answer[Published]:
    """Publish one battery state. Omitted float fields are NaN."""
    order = operations.PublishBattery(await read_json(request), robot)
    state = await operations.publish_battery(parts, principal, order)
    return json_response({"state": fragment(state)})


@router.get("/battery/publisher")
@operation(Role.VIEWER, Scope.ROBOT, errors=(404,))
async def get_publisher(robots: Part[RobotRegistry], robot: RobotQuery = None) -> Answer[Publisher]:
    """Return what the gateway publishes repeatedly."""
    return json_response(robots.get(robot).publisher.document())


@router.put("/battery/publisher", openapi_extra=body(PUBLISHER_REQUEST, required=True))
@carries_out(operations.start_publishing)
async def start_publisher(
    request: Request, parts: AllParts, principal: ThePrincipal, robot: RobotQuery = None
) -> Answer[Publisher]:
    """Start publishing a battery state repeatedly. Replaces what was published before."""
    fields = read_object(await read_json(request), "state", "rate_hz")
    if "state" not in fields:
        raise InvalidField([FieldError("state", "an object, {} for the defaults", "got none")])
    order = operations.StartPublishing(**fields, robot=robot)
    return json_response((await operations.start_publishing(parts, principal, order)).document())


@router.delete("/battery/publisher", status_code=204)
@carries_out(operations.stop_publishing)
async def stop_publisher(parts: AllParts, principal: ThePrincipal, robot: RobotQuery = None) -> Response:
    """Stop publishing."""
    await operations.stop_publishing(parts, principal, robot)
    return Response(status_code=204)


@router.get("/battery/history", openapi_extra=UNSTABLE)
@operation(Role.VIEWER, Scope.ROBOT, errors=(404,))
async def battery_history(
    robots: Part[RobotRegistry],
    known_robots: Part[KnownRobots],
    settings: Part[Settings],
    history: Part[History],
    grant: TheGrant,
    *,
    robot: RobotQuery = None,
    since: SinceQuery = None,
    until: UntilQuery = None,
    points: Annotated[int, Query(ge=2, le=2000)] = 600,
) -> Answer[BatteryHistory]:
    """Return battery measurements from `since` up to but not including `until`, in at most `points` rows.

    `until` defaults to now, and `since` to five minutes before `until`.
    """
    await known_robots.require(robot, grant)
    namespace = robots.default_namespace if robot is None else read_namespace(robot)
    until = until or utc_now()
    since = since or until - DEFAULT_SPAN
    span = divide(namespace, since, until, points, counts_to_100=settings.counts_to_100(namespace))
    return json_response(describe(span, since, until, await history.battery(span)))


def divide(robot: str, since: datetime, until: datetime, points: int, *, counts_to_100: bool = False) -> BatterySpan:
    """Divide a time span into at most `points` buckets.

    Raises:
        InvalidField: The span does not end after its start.
    """
    require_span(since, until)
    first, last = nanoseconds(since), nanoseconds(until)
    # One bucket less: the first may begin before the span, and the last may end after it.
    return BatterySpan(robot, first, last, max(MIN_STEP, -((first - last) // (points - 1))), counts_to_100)


def describe(span: BatterySpan, since: datetime, until: datetime, buckets: list[Bucket]) -> dict[str, Any]:
    """Return the response: one column per field, one row per bucket."""

    def columns(name: str) -> dict[str, list[float | None]]:
        tallies = [bucket.tallies[name] for bucket in buckets]
        return {
            "mean": [short(tally.mean) for tally in tallies],
            "min": [tally.low for tally in tallies],
            "max": [tally.high for tally in tallies],
        }

    return {
        "robot": span.robot,
        "since": since,
        "until": until,
        "resolution_s": span.step / 1e9,
        "time": [moment(bucket.stamp) for bucket in buckets],
        **{name: columns(name) for name in FIELDS},
        "power_supply_status": [bucket.status for bucket in buckets],
    }


def short(value: float | None) -> float | None:
    """Round a mean to 7 significant digits, the precision of a float32."""
    return None if value is None else float(f"{value:.7g}")
