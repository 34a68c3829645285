"""The JSON shapes that several resources share."""

from datetime import datetime
from typing import Annotated, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from dock_gateway.core.errors import Place
from dock_gateway.core.grant import Role
from dock_gateway.http.bodies import GroupName, RobotName, Unique, expected

MAX_ROBOTS, MAX_GROUPS = 500, 20


class OnGraph:
    """Marks a name of the ROS graph. Who shows several graphs together writes it with a prefix."""


# A name of the ROS graph: of a robot, an action or a topic.
RosName = Annotated[str, OnGraph()]


class Schema(BaseModel):
    """Base of the schemas. Every field of an answer is always present; a body has no other fields, and exact types."""

    model_config = ConfigDict(
        json_schema_serialization_defaults_required=True, extra="forbid", strict=True, allow_inf_nan=False
    )


class Identified(Schema):
    """Something that has an id."""

    id: str


class FieldProblem(Schema):
    """One invalid field. `path` is dotted, `in` the part of the request that has it."""

    place: Annotated[Place, Field(serialization_alias="in")]
    path: str
    expected: str
    detail: str


class GatewayAddress(Schema):
    """Where another gateway is, and the patterns of the robots that it serves; none: every robot."""

    host: str
    address: str | None
    robots: list[str]


class Problem(BaseModel):
    """RFC 9457 problem document.

    `errors` lists invalid fields; `goal_id` is the goal that the problem is about, and
    `running_goal_id` the one that keeps the robot busy. If a robot has no docking server:
    `robots` lists those that have one, and `settings` are lines that join the robot with a docking server. `docks` are
    those that the docking server has. Where a setting of the gateway forbids something, `settings` has the line that
    would allow it.

    `gateway` is the one that serves the robot, if this one does not and it is known.

    `robot` has what the request needs, since `since_at`.

    `retry_after` is the number of seconds in the header `Retry-After`, after failed logins.

    `limit` is how many there may be of what is stored, `use` the request to send instead, such as `POST /stop`, and
    `role` the one that suffices.
    """

    model_config = ConfigDict(extra="forbid")

    type: str
    title: str
    status: int
    code: str
    detail: str
    errors: list[FieldProblem] | None = None
    goal_id: str | None = None
    running_goal_id: str | None = None
    retry_after: int | None = None
    limit: int | None = None
    use: str | None = None
    role: Role | None = None
    robots: list[str] | None = None
    docks: list[str] | None = None
    settings: list[str] | None = None
    gateway: GatewayAddress | None = None
    robot: str | None = None
    since_at: datetime | None = None


class RobotSelection(Schema):
    """The robots that something applies to: all, or those named and those in the groups."""

    all: bool = False
    names: Annotated[tuple[RobotName, ...], Field(max_length=MAX_ROBOTS), Unique] = ()
    groups: Annotated[tuple[GroupName, ...], Field(max_length=MAX_GROUPS), Unique] = ()

    @model_validator(mode="after")
    def _are_chosen(self) -> Self:
        if self.all is bool(self.names or self.groups):
            raise expected("either `all`, or robots or groups", "got both" if self.all else "got neither")
        return self

    def covers(self, robot: str, groups: tuple[str, ...]) -> bool:
        """Return whether a robot that is in these groups is one of them."""
        return self.all or robot in self.names or any(group in self.groups for group in groups)
