"""`/robots/label`: the display name and the groups of a robot."""

from fastapi import APIRouter, Depends, Request
from starlette.responses import Response

from dock_gateway.core.errors import FieldError, InvalidField
from dock_gateway.fleet.schema import LABEL_EXAMPLE, Label
from dock_gateway.http.audit_trail import audited
from dock_gateway.http.fields import MAX_ROBOT, read_robot
from dock_gateway.http.openapi import body
from dock_gateway.http.problems import problems
from dock_gateway.http.requests import (
    MAX_GROUP,
    ROBOT_PATTERN,
    TheGateway,
    json_response,
    known_query,
    name_schema,
    read_json,
    read_name,
    read_names,
    read_object,
)
from dock_gateway.http.schema import MAX_GROUPS
from dock_gateway.storage import RobotLabel

router = APIRouter()

FIELDS = ("robot", "display_name", "groups")
MAX_DISPLAY_NAME = 60
LABEL_REQUEST = {
    "type": "object",
    "required": list(FIELDS),
    "additionalProperties": False,
    "properties": {
        "robot": {
            "type": "string",
            "maxLength": MAX_ROBOT,
            "description": "Namespace of the robot, which need not be on the ROS graph",
            **ROBOT_PATTERN,
        },
        "display_name": name_schema(MAX_DISPLAY_NAME)
        | {"type": ["string", "null"], "description": "Belongs to one robot, whatever its case"},
        "groups": {"type": "array", "maxItems": MAX_GROUPS, "items": name_schema(MAX_GROUP)},
    },
    "examples": [LABEL_EXAMPLE],
}


@router.put(
    "/robots/label",
    tags=["Robots"],
    response_model=Label,
    responses=problems(400, 408, 409, 413, 415, 422, 503),
    dependencies=[Depends(known_query())],
    openapi_extra=body(LABEL_REQUEST, required=True),
)
async def label_robot(request: Request, gateway: TheGateway) -> Response:
    """Replace the display name and the groups of a robot, at every gateway that shares the history.

    `null` without groups removes the label. A label outlives restarts, and may be set before the robot appears.
    """
    robot, label = read_label(await read_json(request))
    audited(request, robot=robot)
    await gateway.labels.replace(robot, label)
    return json_response({"robot": robot, **vars(label)})


def read_label(value: object) -> tuple[str, RobotLabel]:
    """Read a robot and its label from a decoded body, without surrounding spaces and groups that repeat.

    Raises:
        InvalidField: It is not a label.
    """
    fields = read_object(value, *FIELDS)
    if missing := [FieldError(name, "a value", "it is missing") for name in FIELDS if name not in fields]:
        raise InvalidField(missing)
    robot, name, groups = (fields[field] for field in FIELDS)
    robot = read_robot(robot, "robot")
    display_name = None if name is None else read_name(name, MAX_DISPLAY_NAME, "display_name")
    return robot, RobotLabel(display_name, read_names(groups, MAX_GROUPS, MAX_GROUP, "groups"))
