"""`/statistics`: how goals ended, by day, robot or action, and how long docking takes."""

import asyncio
from collections.abc import Mapping
from dataclasses import replace
from datetime import UTC, date, datetime, time, timedelta
from typing import Annotated, Any, Literal
from urllib.parse import urlencode
from zoneinfo import ZoneInfo, ZoneInfoNotFoundError

from fastapi import APIRouter, Query
from pydantic import StringConstraints

from dock_gateway.core.errors import FieldError, InvalidField
from dock_gateway.core.event import utc_now
from dock_gateway.core.goal import GoalStatus
from dock_gateway.core.grant import Grant, Role
from dock_gateway.extensions.statistics.schema import DockingTimes, Statistics
from dock_gateway.extensions.statistics.tally import Span, Tallies, Tally, merged, tally_goals
from dock_gateway.extensions.statistics.trends import find_trends, two_weeks
from dock_gateway.goals.queries import GoalSelection, GroupQuery
from dock_gateway.goals.robot_actions import RobotActions
from dock_gateway.http.openapi import UNSTABLE
from dock_gateway.http.operation import Scope, operation
from dock_gateway.http.parts import AllParts, Parts
from dock_gateway.http.principal import TheGrant
from dock_gateway.http.queries import EARLIEST, require_span
from dock_gateway.http.requests import Answer, BelowQuery, json_response
from dock_gateway.http.route import ApiRoute
from dock_gateway.storage import GoalFilter, History

router = APIRouter(route_class=ApiRoute, tags=["Goals"])

DEFAULT_SPAN = timedelta(days=30)
MAX_DAYS = 400
# Error codes listed for a group. Action servers may send any text, so there may be many.
MAX_ERRORS = 20
ENDS = tuple(status for status in GoalStatus if status.terminal)

By = Literal["day", "robot", "action"]
ZONE = r"^[A-Za-z0-9_+\-]+(?:/[A-Za-z0-9_+\-]+)*$"
Zone = Annotated[str, StringConstraints(pattern=ZONE, max_length=64)]
Group = tuple[str, GoalFilter, Tally]


class StatisticsQuery(GoalSelection):
    """Which goals, and how they are grouped."""

    by: Annotated[By, Query(description="What the goals are grouped by")] = "day"
    time_zone: Annotated[
        Zone, Query(description="The time zone of the days, as in the IANA database", examples=["UTC", "Europe/Berlin"])
    ] = "UTC"

    async def to_filter(self, parts: Parts, grant: Grant) -> GoalFilter:
        """Return the filter of the selected goals, with both times set.

        Raises:
            InvalidField: A value is invalid, or the span does not end after its start.
            NotFound: There is and was no such robot (`robot_not_found`).
            Unavailable: The history does not answer (`history_unavailable`).
        """
        until = self.until or utc_now()
        since = self.since or max(until - DEFAULT_SPAN, EARLIEST)
        require_span(since, until)
        return replace(await super().to_filter(parts, grant), since=since, until=until)


@router.get("/statistics")
@operation(Role.VIEWER, Scope.LISTED, errors=(404,))
async def statistics(
    parts: AllParts, grant: TheGrant, query: Annotated[StatisticsQuery, Query()]
) -> Answer[Statistics]:
    """Return how the goals ended that were created from `since` up to but not including `until`.

    `until` defaults to now, and `since` to 30 days before `until`.
    """
    by, wanted, zone = query.by, await query.to_filter(parts, grant), read_zone(query.time_zone)
    whole = _span(wanted)
    days = divide(*whole, zone) if by == "day" else {"": whole}
    found = await tally_goals(parts[History], wanted, list(days.values()), by_action=by != "day")
    if by == "day":
        groups = [
            (day, replace(wanted, since=span[0], until=span[1]), merged(tallies.values()))
            for (day, span), tallies in zip(days.items(), found, strict=True)
        ]
    else:
        keys = parts[RobotActions].robots_of(found[0]) if by == "robot" else {name: name for name in found[0]}
        groups = group(wanted, found[0], keys)
    document = await asyncio.to_thread(describe, wanted, groups)
    return json_response({"since": whole[0], "until": whole[1], "by": by, "time_zone": query.time_zone} | document)


@router.get("/statistics/docking-time", openapi_extra=UNSTABLE)
@operation(Role.VIEWER, Scope.LISTED, errors=(404,))
async def docking_time(
    parts: AllParts, grant: TheGrant, *, robot: BelowQuery = None, group: GroupQuery = None
) -> Answer[DockingTimes]:
    """Return how long docking takes each robot: the last seven days, compared with the seven before."""
    spans = two_weeks(utc_now())
    since, until = spans[0][0], spans[-1][1]
    wanted = await GoalSelection(robot=robot, group=group).to_filter(parts, grant)
    wanted = replace(wanted, since=since, until=until)
    found = await tally_goals(parts[History], wanted, spans, by_action=True)
    trends = find_trends(wanted, found, parts[RobotActions])
    robots = await asyncio.to_thread(lambda: [trend.describe(spans, _path) for trend in trends])
    return json_response({"since": since, "until": until, "robots": robots})


def read_zone(name: str) -> ZoneInfo:
    """Return a time zone.

    Raises:
        InvalidField: There is no such time zone.
    """
    try:
        return ZoneInfo(name)
    except (ZoneInfoNotFoundError, ValueError, OSError):  # such as the name of a folder of zones
        expected = "the name of a time zone, such as UTC or Europe/Berlin"
        raise InvalidField([FieldError("time_zone", expected, f"got {name!r}", "query")]) from None


def divide(since: datetime, until: datetime, zone: ZoneInfo) -> dict[str, Span]:
    """Divide a time span into the days of a time zone. A day has 23 to 25 hours; the first and the last may be cut off.

    Raises:
        InvalidField: There are too many days.
    """
    day = since.astimezone(zone).date()
    last = (until - timedelta(microseconds=1)).astimezone(zone).date()
    if (last - day).days >= MAX_DAYS:
        expected = f"at most {MAX_DAYS} days before `until`, or `by=robot` or `by=action`"
        raise InvalidField([FieldError("since", expected, f"got {since.isoformat()}", "query")])
    days: dict[str, Span] = {}
    while day <= last:
        begin, end = max(since, _midnight(day, zone)), min(until, _midnight(day + timedelta(days=1), zone))
        if begin < end:  # a zone that changed sides of the date line has left out a day
            days[day.isoformat()] = begin, end
        day += timedelta(days=1)
    return days


def _midnight(day: date, zone: ZoneInfo) -> datetime:
    return datetime.combine(day, time(), zone).astimezone(UTC)


def group(wanted: GoalFilter, found: Tallies, keys: Mapping[str, str]) -> list[Group]:
    """Put the tallies of actions into groups, sorted by key; each with the filter that selects its goals."""
    groups: dict[str, Tallies] = {}
    for action_name, tally in found.items():
        groups.setdefault(keys[action_name], {})[action_name] = tally
    return [
        (key, replace(wanted, namespace="/", action_names=frozenset(tallies)), merged(tallies.values()))
        for key, tallies in sorted(groups.items())
    ]


def describe(wanted: GoalFilter, groups: list[Group]) -> dict[str, Any]:
    """Return the total and the groups of the response."""
    return {
        "total": _describe(wanted, merged(tally for _, _, tally in groups)),
        "groups": [{"key": key} | _describe(chosen, tally) for key, chosen, tally in groups],
    }


def _describe(chosen: GoalFilter, tally: Tally) -> dict[str, Any]:
    p10, median, p90 = tally.percentiles(10, 50, 90)
    errors = sorted(tally.errors.items(), key=lambda item: (-item[1], item[0]))
    return {
        "ended": tally.ended,
        "statuses": {status.value: tally.statuses[status] for status in ENDS},
        "success_rate": _short(tally.success_rate),
        "duration_s": {"p10": _short(p10), "median": _short(median), "p90": _short(p90)},
        "mean_retries": _short(tally.mean_retries),
        "errors": [{"code": code, "count": count} for code, count in errors[:MAX_ERRORS]],
        "other_errors": sum(count for _, count in errors[MAX_ERRORS:]),
        "goals_path": _path(chosen),
    }


def _short(value: float | None) -> float | None:
    return None if value is None else round(value, 3 if abs(value) >= 1 else 6)


def _path(chosen: GoalFilter) -> str:
    """Return the path that lists the goals of a filter."""
    query = [
        *([("robot", chosen.namespace)] if chosen.namespace != "/" else []),
        *(("action", name) for name in sorted(chosen.action_names)),
        *([("origin", chosen.origin)] if chosen.origin is not None else []),
        *(("tag", tag) for tag in sorted(chosen.tags)),
        *([("group", chosen.group)] if chosen.group is not None else []),
        *zip(("since", "until"), (each.isoformat().replace("+00:00", "Z") for each in _span(chosen)), strict=True),
    ]
    return f"/goals?{urlencode(query, safe='/:')}"


def _span(wanted: GoalFilter) -> Span:
    assert wanted.since is not None
    assert wanted.until is not None
    return wanted.since, wanted.until
