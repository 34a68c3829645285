"""`/robots/label`: the display name and the groups of a robot."""

from fastapi import APIRouter, Depends, Request
from starlette.responses import Response

from dock_gateway.core.grant import Role
from dock_gateway.fleet.schema import Label
from dock_gateway.http.audit_trail import audited
from dock_gateway.http.bodies import body_schema, read
from dock_gateway.http.openapi import body
from dock_gateway.http.operation import Scope, operation
from dock_gateway.http.problems import problems
from dock_gateway.http.requests import (
    TheGateway,
    json_response,
    known_query,
)
from dock_gateway.storage import RobotLabel

router = APIRouter()


@router.put(
    "/robots/label",
    tags=["Robots"],
    response_model=Label,
    responses=problems(400, 408, 409, 413, 415, 422, 503),
    dependencies=[Depends(known_query())],
    openapi_extra=body(body_schema(Label), required=True),
)
@operation(Role.SUPERVISOR, Scope.EVERY)
async def label_robot(request: Request, gateway: TheGateway) -> Response:
    """Replace the display name and the groups of a robot, at every gateway that shares the history.

    `null` without groups removes the label. A label outlives restarts, and may be set before the robot appears.
    """
    label = await read(Label, request)
    audited(request, robot=label.robot)
    await gateway.labels.replace(label.robot, RobotLabel(label.display_name, label.groups))
    return json_response(label.model_dump())
