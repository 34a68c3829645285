"""Answers that more than one route gives."""

import re
import uuid
from typing import Annotated

from fastapi import Depends, Path, Query
from starlette.responses import Response

from dock_gateway.api.requests import depend_on_gateway
from dock_gateway.errors import FieldError, InvalidField
from dock_gateway.gateway import Gateway
from dock_gateway.goals import Goal, GoalStatus, encode
from dock_gateway.robots import NAME_PART, NAMESPACE

GOAL_ID = re.compile(r"[0-9A-Fa-f]{8}-?(?:[0-9A-Fa-f]{4}-?){3}[0-9A-Fa-f]{12}")

TheGateway = Annotated[Gateway, Depends(depend_on_gateway)]
# A name on the ROS graph without the slash that it begins with.
GraphName = Annotated[
    str,
    Path(
        description="The name on the ROS graph without its first slash",
        json_schema_extra={"pattern": f"^{NAME_PART}(?:/{NAME_PART})*$"},
    ),
]
ROBOT_PATTERN = {"pattern": f"^{NAMESPACE.pattern}$"}
RobotQuery = Annotated[
    str | None, Query(description="Namespace of the robot, such as `/robot1`", json_schema_extra=ROBOT_PATTERN)
]
StatusQuery = Annotated[list[GoalStatus] | None, Query(description="Only goals in these states")]
LimitQuery = Annotated[int, Query(ge=1, le=500)]
CursorQuery = Annotated[uuid.UUID | None, Query(description="`next_cursor` of the page before")]


def json_response(document: object, status: int = 200, headers: dict[str, str] | None = None) -> Response:
    """An answer in JSON, as the whole gateway writes it."""
    return Response(encode(document), status, headers, "application/json")


def goal_response(goal: Goal, location: str, status: int = 200) -> Response:
    """A goal, and where it is found from now on."""
    return json_response(goal.document(), status, {"Location": location})


def read_goal_id(goal_id: str) -> str:
    """A goal id in its canonical form; `ros2 action send_goal` prints it without the hyphens.

    Raises:
        InvalidField: It is not a UUID.
    """
    if not GOAL_ID.fullmatch(goal_id):
        raise InvalidField([FieldError("goal_id", "a UUID", f"got {goal_id[:60]!r}")])
    return str(uuid.UUID(goal_id))


async def _goal_id_in_path(goal_id: Annotated[str, Path(json_schema_extra={"pattern": f"^{GOAL_ID.pattern}$"})]) -> str:
    return read_goal_id(goal_id)


GoalId = Annotated[str, Depends(_goal_id_in_path)]
