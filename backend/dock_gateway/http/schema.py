"""The JSON shapes that several resources share."""

from pydantic import BaseModel, ConfigDict


class Schema(BaseModel):
    """Base of the schemas. Every field is always present."""

    model_config = ConfigDict(json_schema_serialization_defaults_required=True, extra="forbid")


class FieldProblem(Schema):
    """One invalid field."""

    path: str
    expected: str
    detail: str


class Problem(BaseModel):
    """RFC 9457 problem document.

    `errors` lists invalid fields; `goal_id` is the goal that the problem is about. If a robot has no docking server:
    `robots` lists those that have one, and `settings` are lines that join the robot with a docking server.

    `retry_after` is the number of seconds in the header `Retry-After`, after failed logins.
    """

    model_config = ConfigDict(extra="forbid")

    type: str
    title: str
    status: int
    code: str
    detail: str
    errors: list[FieldProblem] | None = None
    goal_id: str | None = None
    retry_after: int | None = None
    robots: list[str] | None = None
    settings: list[str] | None = None


class RobotSelection(Schema):
    """The robots that something applies to: all, or those named and those in the groups."""

    all: bool
    names: list[str]
    groups: list[str]
