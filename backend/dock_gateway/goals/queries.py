"""Query parameters that select goals: `?robot= ?status= …`."""

import re
from dataclasses import replace
from typing import Annotated

from fastapi import Query
from pydantic import AfterValidator, BaseModel, ConfigDict, StringConstraints

from dock_gateway.core.goal import Origin, Verb
from dock_gateway.core.grant import Grant
from dock_gateway.core.namespace import read_namespace
from dock_gateway.goals.known_robots import KnownRobots
from dock_gateway.goals.robot_actions import RobotActions
from dock_gateway.http.parts import Parts
from dock_gateway.http.queries import SinceQuery, UntilQuery, require_span
from dock_gateway.http.requests import LINE_OF_TEXT, MAX_GROUP, MAX_TAG, BelowQuery, StatusQuery
from dock_gateway.setting_types import LONGEST_NAME, TOPIC
from dock_gateway.settings import Settings
from dock_gateway.storage import GoalFilter

ActionName = Annotated[str, StringConstraints(pattern=f"^{TOPIC.pattern}$", max_length=LONGEST_NAME)]
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
Group = Annotated[str, StringConstraints(max_length=MAX_GROUP, pattern=f"^{LINE_OF_TEXT.pattern}$")]
GroupQuery = Annotated[
    Group | None, Query(description="Only goals on actions of the robots that are in this group now")
]


class GoalSelection(BaseModel):
    """Query parameters that select goals, also in statistics. Actions and robots may have left the graph."""

    model_config = ConfigDict(frozen=True)

    robot: BelowQuery = None
    action: Annotated[list[ActionName] | None, Query(description="Only goals on these actions")] = None
    origin: Annotated[Origin | None, Query(description="Only goals of this origin")] = None
    since: SinceQuery = None
    until: UntilQuery = None
    tag: Annotated[list[Tag] | None, Query(description="Only goals with one of these tags")] = None
    group: GroupQuery = None

    async def to_filter(self, parts: Parts, grant: Grant) -> GoalFilter:
        """Return the filter of the selected goals.

        Raises:
            InvalidField: A value is invalid.
            NotFound: There is and was no such robot (`robot_not_found`).
            Unavailable: The history does not answer (`history_unavailable`).
        """
        require_span(self.since, self.until)
        settings, robot_actions = parts[Settings], parts[RobotActions]
        namespace = "/" if self.robot is None else read_namespace(self.robot)
        under = None if self.robot is None else namespace
        await parts[KnownRobots].require(self.robot, grant)
        group = None if self.group is None else self.group.strip()
        return GoalFilter(
            action_names=frozenset(settings.resolve(name, under) for name in self.action or ()),
            namespace=namespace,
            origin=self.origin,
            since=self.since,
            until=self.until,
            tags=frozenset(name.strip() for name in self.tag or ()),
            group=group,
            among=await robot_actions.choose_actions(grant, group),
            homed=robot_actions.homed_in(self.robot),
        )


class GoalQuery(GoalSelection):
    """Query parameters that select goals, where the path may say the verb."""

    status: StatusQuery = None
    error: Annotated[list[ErrorCode] | None, Query(description="Only goals with these error codes")] = None
    id: IdPrefixQuery = None

    async def to_filter(self, parts: Parts, grant: Grant) -> GoalFilter:
        """Return the filter of the selected goals; errors as those of `GoalSelection`."""
        return replace(
            await super().to_filter(parts, grant),
            statuses=frozenset(self.status or ()),
            error_codes=frozenset(self.error or ()),
            id_prefix=self.id or "",
        )


class AnyGoalQuery(GoalQuery):
    """Query parameters that select goals of all actions."""

    verb: Annotated[Verb | None, Query(description="Only goals that dock, or that undock")] = None

    async def to_filter(self, parts: Parts, grant: Grant) -> GoalFilter:
        """Return the filter of the selected goals; errors as those of `GoalSelection`."""
        return replace(await super().to_filter(parts, grant), verb=self.verb)
