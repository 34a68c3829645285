"""`/battery/history`: battery measurements over a time span, reduced to the points of a plot."""

from datetime import datetime, timedelta
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Query
from starlette.responses import Response

from dock_gateway.core.errors import FieldError, InvalidField
from dock_gateway.core.event import moment, nanoseconds, utc_now
from dock_gateway.core.grant import Role
from dock_gateway.core.namespace import read_namespace
from dock_gateway.http.operation import Scope, operation
from dock_gateway.http.parts import Part
from dock_gateway.http.problems import problems
from dock_gateway.http.queries import SinceQuery, UntilQuery
from dock_gateway.http.requests import RobotQuery, json_response, known_query
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway.robots.schema import BatteryHistory
from dock_gateway.settings import Settings
from dock_gateway.storage import History
from dock_gateway.storage.battery import FIELDS, BatterySpan, Bucket

router = APIRouter(tags=["Battery"])

DEFAULT_SPAN = timedelta(minutes=5)
MIN_STEP = 1_000  # nanoseconds; the API gives times in microseconds


@router.get(
    "/battery/history",
    response_model=BatteryHistory,
    responses=problems(422, 503),
    dependencies=[Depends(known_query("robot", "since", "until", "points"))],
)
@operation(Role.VIEWER, Scope.ROBOT)
async def battery_history(
    robots: Part[RobotRegistry],
    settings: Part[Settings],
    history: Part[History],
    *,
    robot: RobotQuery = None,
    since: SinceQuery = None,
    until: UntilQuery = None,
    points: Annotated[int, Query(ge=2, le=2000)] = 600,
) -> Response:
    """Return battery measurements from `since` up to but not including `until`, in at most `points` rows.

    `until` defaults to now, and `since` to five minutes before `until`.
    """
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
    first, last = nanoseconds(since), nanoseconds(until)
    if first >= last:
        raise InvalidField([FieldError("query.since", "a time before `until`", f"got {since.isoformat()}")])
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
