"""Query parameters that select goals (`?robot= ?status= …`) or the events of a stream (`?include= ?after= …`)."""

import re
from collections.abc import Mapping
from datetime import UTC, datetime
from typing import Annotated

from fastapi import Depends, Query
from pydantic import AfterValidator, AwareDatetime, BeforeValidator, StringConstraints

from dock_gateway.core.errors import FieldError, InvalidField, got
from dock_gateway.core.filters import EventFilter, WithoutFeedback
from dock_gateway.core.goal import Origin
from dock_gateway.core.grant import Grant
from dock_gateway.core.namespace import read_namespace
from dock_gateway.gateway import Gateway
from dock_gateway.http.owners import choose_actions
from dock_gateway.http.principal import TheGrant
from dock_gateway.http.requests import MAX_GROUP, MAX_TAG, NAME, ROBOT_PATTERN, StatusQuery, TheGateway, read_goal_id
from dock_gateway.http.scopes import not_covered
from dock_gateway.settings import LONGEST_NAME, TOPIC
from dock_gateway.storage import GoalFilter

QUERY = ("robot", "action", "status", "error", "origin", "since", "until", "id", "tag", "group")
# The range of ROS times, which are 64-bit nanoseconds.
EARLIEST, LATEST = datetime(1970, 1, 1, tzinfo=UTC), datetime(2262, 1, 1, tzinfo=UTC)
RFC_3339 = re.compile(
    r"(?:19[7-9][0-9]|2[01][0-9]{2}|22[0-5][0-9]|226[01])-(?:0[1-9]|1[0-2])-(?:0[1-9]|[12][0-9]|3[01])"
    r"[Tt](?:[01][0-9]|2[0-3]):[0-5][0-9]:[0-5][0-9](?:\.[0-9]+)?(?:[Zz]|[+-](?:[01][0-9]|2[0-3]):[0-5][0-9])"
)


def _as_documented(text: object) -> object:
    """Refuse times out of range, and the numbers and shorter forms that pydantic also accepts."""
    if not isinstance(text, str) or not RFC_3339.fullmatch(text):
        raise ValueError("an RFC 3339 time from 1970 to 2261, such as 2026-11-21T03:32:40Z")
    return text


def _in_utc(time: datetime) -> datetime:
    """Return the time in UTC, clamped to the supported range."""
    return min(max(time.astimezone(UTC), EARLIEST), LATEST)


Time = Annotated[AwareDatetime, BeforeValidator(_as_documented), AfterValidator(_in_utc)]
ActionName = Annotated[str, StringConstraints(pattern=f"^{TOPIC.pattern}$", max_length=LONGEST_NAME)]
TIME_PATTERN = {"pattern": f"^{RFC_3339.pattern}$"}
SinceQuery = Annotated[
    Time | None, Query(description="At this time or later, RFC 3339", json_schema_extra=TIME_PATTERN)
]
UntilQuery = Annotated[Time | None, Query(description="Before this time, RFC 3339", json_schema_extra=TIME_PATTERN)]
NamespaceQuery = Annotated[
    str | None,
    Query(description="Only goals on actions in this namespace or below", json_schema_extra=ROBOT_PATTERN),
]
ActionsQuery = Annotated[list[ActionName] | None, Query(description="Only goals on these actions")]
OriginQuery = Annotated[Origin | None, Query(description="Only goals of this origin")]
# Action servers may send any text; databases do not accept NUL.
ErrorCode = Annotated[str, StringConstraints(min_length=1, max_length=200, pattern=r"^[^\x00]*$")]

HEX_DIGITS = re.compile(r"(?:[0-9A-Fa-f]-?){4,32}")
HYPHENS_BEFORE = (8, 12, 16, 20)  # which hexadecimal digits of a UUID follow a hyphen


def _id_prefix(text: str) -> str:
    """Return the beginning of a goal id as goal ids are stored: in lower case, with a UUID's hyphens."""
    if not HEX_DIGITS.fullmatch(text):
        raise ValueError("the first 4 or more hexadecimal digits of a goal id, with or without its hyphens")
    digits = text.replace("-", "").lower()
    return "".join(f"-{digit}" if at in HYPHENS_BEFORE else digit for at, digit in enumerate(digits))


IdPrefixQuery = Annotated[
    Annotated[str, AfterValidator(_id_prefix)] | None,
    Query(
        description="Only goals whose id begins with this: 4 or more hexadecimal digits",
        json_schema_extra={"pattern": f"^{HEX_DIGITS.pattern}$"},
    ),
]
Tag = Annotated[str, StringConstraints(max_length=MAX_TAG, pattern=f"^{NAME.pattern}$")]
TagsQuery = Annotated[list[Tag] | None, Query(description="Only goals with one of these tags")]
Group = Annotated[str, StringConstraints(max_length=MAX_GROUP, pattern=f"^{NAME.pattern}$")]
GroupQuery = Annotated[
    Group | None, Query(description="Only goals on actions of the robots that are in this group now")
]


async def read_goal_filter(
    *,
    gateway: TheGateway,
    grant: TheGrant,
    robot: NamespaceQuery = None,
    action: ActionsQuery = None,
    status: StatusQuery = None,
    error: Annotated[list[ErrorCode] | None, Query(description="Only goals with these error codes")] = None,
    origin: OriginQuery = None,
    since: SinceQuery = None,
    until: UntilQuery = None,
    id: IdPrefixQuery = None,  # noqa: A002 - it is what clients call it
    tag: TagsQuery = None,
    group: GroupQuery = None,
) -> GoalFilter:
    """Return the goal filter of a query. Its actions and robots may have left the graph.

    Raises:
        InvalidField: A value is invalid.
        Unavailable: The history does not answer (`history_unavailable`).
    """
    namespace = "/" if robot is None else read_namespace(robot)
    under = None if robot is None else namespace
    group = None if group is None else group.strip()
    return GoalFilter(
        action_names=frozenset(gateway.settings.resolve(name, under) for name in action or ()),
        namespace=namespace,
        statuses=frozenset(status or ()),
        error_codes=frozenset(error or ()),
        origin=origin,
        since=since,
        until=until,
        id_prefix=id or "",
        tags=frozenset(name.strip() for name in tag or ()),
        group=group,
        among=await choose_actions(gateway, grant, group),
        homed=_homed(gateway, robot),
    )


GoalFilterQuery = Annotated[GoalFilter, Depends(read_goal_filter)]


STREAM_QUERY = ("goal_id", "action", "robot", "include", "feedback")
INCLUDES = ("battery", "cmd_vel", "system", "scene", "scenes", "robots")
EVENT_ID = re.compile(r"[0-9]{20}-[A-Za-z0-9_/-]{1,300}")
MIN_RATE, MAX_RATE = 0.01, 1000.0


def read_after(query: Mapping[str, str]) -> str | None:
    """Return the id of the event to resume after.

    Raises:
        InvalidField: It is not the id of an event.
    """
    after = query.get("after")
    if after is not None and not EVENT_ID.fullmatch(after):
        raise InvalidField([FieldError("query.after", "the id of an event", f"got {after[:60]!r}")])
    return after


def read_max_rate(query: Mapping[str, str], lowest: float = MIN_RATE, highest: float = MAX_RATE) -> float | None:
    """Return the reader's maximum rate, in messages per second.

    Raises:
        InvalidField: The value is not a number in range.
    """
    text = query.get("max_rate")
    if text is None:
        return None
    try:
        rate = float(text)
    except ValueError:
        rate = 0.0
    if not lowest <= rate <= highest:
        expected = f"a number from {lowest:g} to {highest:g}"
        raise InvalidField([FieldError("query.max_rate", expected, f"got {text[:60]!r}")])
    return rate


def read_feedback(query: Mapping[str, str]) -> bool:
    """Whether feedback is wanted.

    Raises:
        InvalidField: It is neither true nor false.
    """
    text = query.get("feedback", "true").lower()
    if text not in ("true", "false"):
        raise InvalidField([FieldError("query.feedback", "true or false", f"got {text[:60]!r}")])
    return text == "true"


async def read_event_filter(gateway: Gateway, query: Mapping[str, str], grant: Grant) -> EventFilter:
    """Return the event filter of a query, for a reader with this grant.

    Without `robot`, goals are those of all robots that the grant covers; battery, velocity and scene are those of the
    configured robot, or of the first one that the grant covers.

    Raises:
        InvalidField: A value is invalid.
        NotFound: There is no such goal or robot, or the grant does not cover the goal.
        NotAllowed: The grant does not cover the robot (`not_covered`).
    """
    robot, action, goal_id = query.get("robot"), query.get("action"), query.get("goal_id")
    namespace = "/" if robot is None else read_namespace(robot)
    if action is not None and (len(action) > LONGEST_NAME or not TOPIC.fullmatch(action)):
        raise InvalidField([FieldError("query.action", "the name of an action", got(action))])
    names = [name.strip() for name in query.get("include", "").split(",") if name.strip()]
    if unknown := [name for name in names if name not in INCLUDES]:
        raise InvalidField([FieldError("query.include", f"any of {', '.join(INCLUDES)}", f"got {unknown[0][:60]!r}")])
    kind = EventFilter if read_feedback(query) else WithoutFeedback
    goal = None if goal_id is None else await gateway.goal(read_goal_id(goal_id), grant)
    return kind(
        topics=frozenset({"goals", *names}),
        goal_id=None if goal is None else goal.goal_id,
        action_name=None if action is None else gateway.settings.resolve(action, None if robot is None else namespace),
        namespace=namespace,
        robot=_read_robot(gateway, robot, grant),
        grant=grant if grant.limited else None,
        homed=_homed(gateway, robot),
    )


def _homed(gateway: Gateway, robot: str | None) -> frozenset[str]:
    """Return the actions elsewhere that belong to robots in a namespace; without one, all actions are meant anyway."""
    return frozenset() if robot is None else gateway.actions.docking.catalog.homed_in(read_namespace(robot))


def _read_robot(gateway: Gateway, robot: str | None, grant: Grant) -> str:
    # Whether there is such a robot or not.
    if robot is not None and not grant.covers_robot(name := read_namespace(robot)):
        raise not_covered(f"the robot {name}")
    found = gateway.robots.get(robot).namespace
    if grant.covers_robot(found):
        return found
    covered = [each.namespace for each in gateway.robots.all() if grant.covers_robot(each.namespace)]
    if not covered:
        raise not_covered(f"the robot {found}")
    return min(covered)
