"""Which goals a request asks for, out of its query: `?robot= ?action= ?status= ?origin= ?since= ?until=`."""

from datetime import UTC, datetime
from typing import Annotated

from fastapi import Depends, Query
from pydantic import AfterValidator, AwareDatetime

from dock_gateway.api.answers import StatusQuery, TheGateway
from dock_gateway.goals import Origin
from dock_gateway.history import Wanted
from dock_gateway.robots import read_namespace

QUERY = ("robot", "action", "status", "origin", "since", "until")
# What nanoseconds in 64 bits reach, as ROS has them.
EARLIEST, LATEST = datetime(1970, 1, 1, tzinfo=UTC), datetime(2262, 1, 1, tzinfo=UTC)


def _within_reach(time: datetime) -> datetime:
    if not EARLIEST <= time <= LATEST:
        raise ValueError(f"a time from {EARLIEST:%Y} to {LATEST:%Y}")
    return time.astimezone(UTC)


Time = Annotated[AwareDatetime, AfterValidator(_within_reach)]
SinceQuery = Annotated[Time | None, Query(description="At this time or later, RFC 3339")]
UntilQuery = Annotated[Time | None, Query(description="Before this time, RFC 3339")]


async def read_wanted(
    *,
    gateway: TheGateway,
    robot: Annotated[str | None, Query(description="Only goals on actions in this namespace or below")] = None,
    action: Annotated[list[str] | None, Query(description="Only goals on these actions")] = None,
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
