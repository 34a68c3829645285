"""The JSON shapes of approvals."""

from datetime import datetime
from typing import Any, Literal

from pydantic import ConfigDict

from dock_gateway.http.schema import RosName, Schema


class Approval(Schema):
    """An agent's goal to a real robot, which waits until a person allows it.

    `agent` is the agent's name, `client` its program as it calls itself; null for a goal by REST or `/ws`. `goal` is
    the goal message. At `expires_at` the goal is refused.
    """

    id: str
    agent: str
    client: str | None
    robot: RosName
    action_name: RosName
    verb: Literal["dock", "undock"] | None
    goal: dict[str, Any]
    requested_at: datetime
    expires_at: datetime


class ApprovalList(Schema):
    """The goals that wait, oldest first."""

    approvals: list[Approval]


class ApprovalBody(Schema):
    """The answer of a person: whether the robot may get the goal."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"allow": True}]})

    allow: bool
