"""Query parameters that select goals: `?robot= ?status= …`."""

import re
from dataclasses import replace
from typing import Annotated

from fastapi import Depends, Query
from pydantic import AfterValidator, StringConstraints

from dock_gateway.core.goal import Origin, Verb
from dock_gateway.core.namespace import read_namespace
from dock_gateway.goals.known_robots import KnownRobots
from dock_gateway.goals.robot_actions import RobotActions
from dock_gateway.http.parts import Part
from dock_gateway.http.principal import TheGrant
from dock_gateway.http.queries import SinceQuery, UntilQuery
from dock_gateway.http.requests import LINE_OF_TEXT, MAX_GROUP, MAX_TAG, BelowQuery, StatusQuery
from dock_gateway.setting_types import LONGEST_NAME, TOPIC
from dock_gateway.settings import Settings
from dock_gateway.storage import GoalFilter

ActionName = Annotated[str, StringConstraints(pattern=f"^{TOPIC.pattern}$", max_length=LONGEST_NAME)]
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
Tag = Annotated[str, StringConstraints(max_length=MAX_TAG, pattern=f"^{LINE_OF_TEXT.pattern}$")]
TagsQuery = Annotated[list[Tag] | None, Query(description="Only goals with one of these tags")]
Group = Annotated[str, StringConstraints(max_length=MAX_GROUP, pattern=f"^{LINE_OF_TEXT.pattern}$")]
GroupQuery = Annotated[
    Group | None, Query(description="Only goals on actions of the robots that are in this group now")
]


async def read_goal_filter(
    *,
    settings: Part[Settings],
    robot_actions: Part[RobotActions],
    known_robots: Part[KnownRobots],
    grant: TheGrant,
    robot: BelowQuery = None,
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
        NotFound: There is and was no such robot (`robot_not_found`).
        Unavailable: The history does not answer (`history_unavailable`).
    """
    namespace = "/" if robot is None else read_namespace(robot)
    under = None if robot is None else namespace
    await known_robots.require(robot, grant)
    group = None if group is None else group.strip()
    return GoalFilter(
        action_names=frozenset(settings.resolve(name, under) for name in action or ()),
        namespace=namespace,
        statuses=frozenset(status or ()),
        error_codes=frozenset(error or ()),
        origin=origin,
        since=since,
        until=until,
        id_prefix=id or "",
        tags=frozenset(name.strip() for name in tag or ()),
        group=group,
        among=await robot_actions.choose_actions(grant, group),
        homed=robot_actions.homed_in(robot),
    )


# The goals of some robots, and of those the ones that dock or undock.
AnyVerbQuery = Annotated[GoalFilter, Depends(read_goal_filter)]
VerbQuery = Annotated[Verb | None, Query(description="Only goals that dock, or that undock")]


async def _of_verb(wanted: AnyVerbQuery, verb: VerbQuery = None) -> GoalFilter:
    return replace(wanted, verb=verb)


GoalFilterQuery = Annotated[GoalFilter, Depends(_of_verb)]
