"""Answers that more than one route gives."""

import uuid
from typing import Annotated

from fastapi import Depends, Query
from starlette.responses import Response

from dock_gateway.api.requests import depend_on_gateway
from dock_gateway.errors import FieldError, InvalidField
from dock_gateway.gateway import Gateway
from dock_gateway.goals import Goal, GoalStatus, encode

TheGateway = Annotated[Gateway, Depends(depend_on_gateway)]
RobotQuery = Annotated[str | None, Query(description="Namespace of the robot, such as `/robot1`")]
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
    """A goal id in its canonical form.

    Raises:
        InvalidField: It is not a UUID.
    """
    try:
        return str(uuid.UUID(goal_id))
    except ValueError:
        raise InvalidField([FieldError("goal_id", "a UUID", f"got {goal_id[:60]!r}")]) from None


async def _goal_id_in_path(goal_id: str) -> str:
    return read_goal_id(goal_id)


GoalId = Annotated[str, Depends(_goal_id_in_path)]
