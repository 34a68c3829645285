"""Which goals a request asks for, out of its query: `?robot= ?action= ?status= ?origin= ?since= ?until=`."""

import re
from datetime import UTC, datetime
from typing import Annotated

from fastapi import Depends, Query
from pydantic import AfterValidator, AwareDatetime, BeforeValidator, StringConstraints

from dock_gateway.api.answers import ROBOT_PATTERN, StatusQuery, TheGateway
from dock_gateway.goals import Origin
from dock_gateway.history import Wanted
from dock_gateway.robots import NAME_PART, read_namespace

QUERY = ("robot", "action", "status", "origin", "since", "until")
# What nanoseconds in 64 bits reach, as ROS has them.
EARLIEST, LATEST = datetime(1970, 1, 1, tzinfo=UTC), datetime(2262, 1, 1, tzinfo=UTC)
RFC_3339 = re.compile(
    r"(?:19[7-9][0-9]|2[01][0-9]{2}|22[0-5][0-9]|226[01])-(?:0[1-9]|1[0-2])-(?:0[1-9]|[12][0-9]|3[01])"
    r"[Tt](?:[01][0-9]|2[0-3]):[0-5][0-9]:[0-5][0-9](?:\.[0-9]+)?(?:[Zz]|[+-](?:[01][0-9]|2[0-3]):[0-5][0-9])"
)


def _as_documented(text: object) -> object:
    """Refuse the numbers and shorter forms that pydantic takes for times, too, and what is out of reach."""
    if not isinstance(text, str) or not RFC_3339.fullmatch(text):
        raise ValueError("a time as of RFC 3339, from 1970 to 2261, such as 2026-11-21T03:32:40Z")
    return text


def _in_utc(time: datetime) -> datetime:
    """The time in UTC, and not beyond reach by its time zone."""
    return min(max(time.astimezone(UTC), EARLIEST), LATEST)


Time = Annotated[AwareDatetime, BeforeValidator(_as_documented), AfterValidator(_in_utc)]
ActionName = Annotated[str, StringConstraints(pattern=f"^/?{NAME_PART}(?:/{NAME_PART})*$")]
TIME_PATTERN = {"pattern": f"^{RFC_3339.pattern}$"}
SinceQuery = Annotated[
    Time | None, Query(description="At this time or later, RFC 3339", json_schema_extra=TIME_PATTERN)
]
UntilQuery = Annotated[Time | None, Query(description="Before this time, RFC 3339", json_schema_extra=TIME_PATTERN)]


async def read_wanted(
    *,
    gateway: TheGateway,
    robot: Annotated[
        str | None,
        Query(description="Only goals on actions in this namespace or below", json_schema_extra=ROBOT_PATTERN),
    ] = None,
    action: Annotated[list[ActionName] | None, Query(description="Only goals on these actions")] = None,
    status: StatusQuery = None,
    origin: Annotated[Origin | None, Query(description="Only goals that were sent so")] = None,
    since: SinceQuery = None,
    until: UntilQuery = None,
) -> Wanted:
    """The goals that a query describes; they may be on actions and of robots that have left the graph.

    Raises:
        InvalidField: A value is wrong.
    """
    namespace = "/" if robot is None else read_namespace(robot)
    under = None if robot is None else namespace
    return Wanted(
        frozenset(gateway.settings.resolve(name, under) for name in action or ()),
        namespace,
        frozenset(status or ()),
        origin,
        since,
        until,
    )


WantedQuery = Annotated[Wanted, Depends(read_wanted)]
