"""`/simulator`: manual control of a simulated robot. A real robot has no simulator."""

import math
from typing import Annotated, Literal

from fastapi import APIRouter, Depends, Path, Request
from starlette.responses import Response

from dock_gateway.core.errors import FieldError, InvalidField, got
from dock_gateway.core.scene import Pose
from dock_gateway.gateway import Gateway
from dock_gateway.http.openapi import body
from dock_gateway.http.problems import problems
from dock_gateway.http.requests import RobotQuery, TheGateway, json_response, known_query, read_json, read_object
from dock_gateway.robots.schema import Simulator

router = APIRouter(tags=["Simulator"], prefix="/simulator", dependencies=[Depends(known_query("robot"))])

FARTHEST = 100.0
Fault = Literal[
    "dead_charger",
    "flickering_charge",
    "occluded_marker",
    "stuck_wheel",
    "late_commands",
    "worn_wheel",
    "wrong_detections",
    "future_detections",
    "repeated_odometry",
    "obstacle",
    "hidden_beacon",
    "infrared_ghosts",
    "silent_battery",
    "percentage_0_to_100",
]
FaultPath = Annotated[Fault, Path(description="What breaks")]
NUMBER = {"type": "number", "minimum": -FARTHEST, "maximum": FARTHEST}
PLACE_REQUEST = {
    "type": "object",
    "required": ["x", "y", "theta"],
    "additionalProperties": False,
    "description": "In m and rad, in the frame `world`: the dock is at its origin, and a theta of 0 looks into it",
    "properties": {"x": NUMBER, "y": NUMBER, "theta": NUMBER},
}
FAULT_REQUEST = {
    "type": "object",
    "required": ["active"],
    "additionalProperties": False,
    "properties": {"active": {"type": "boolean"}},
}


def _robot(gateway: Gateway, robot: str | None) -> str:
    return gateway.robots.get(robot).namespace


def read_pose(value: object) -> Pose:
    """Read a pose from a decoded body.

    Raises:
        InvalidField: It is not a pose, or it is too far away.
    """
    fields = read_object(value, *Pose._fields)
    errors = [
        FieldError(name, f"a number from {-FARTHEST:g} to {FARTHEST:g}", got(given))
        for name in Pose._fields
        if isinstance(given := fields.get(name), bool)
        or not isinstance(given, int | float)
        or not abs(given) <= FARTHEST
    ]
    if errors:
        raise InvalidField(errors)
    return Pose(float(fields["x"]), float(fields["y"]), math.remainder(fields["theta"], math.tau))


@router.get("", response_model=Simulator, responses=problems(404, 422))
async def get_simulator(gateway: TheGateway, robot: RobotQuery = None) -> Response:
    """Return the active faults, and whether the robot touches its dock and is charged there."""
    return json_response(gateway.simulators.get(_robot(gateway, robot)).document())


@router.post("/reset", response_model=Simulator, responses=problems(404, 422, 503, 504))
async def reset_simulator(gateway: TheGateway, robot: RobotQuery = None) -> Response:
    """Move the robot to its start pose, restore its battery, and clear every fault."""
    return json_response(await gateway.simulators.reset(_robot(gateway, robot)))


@router.post(
    "/place",
    response_model=Simulator,
    responses=problems(400, 404, 408, 413, 415, 422, 503, 504),
    openapi_extra=body(PLACE_REQUEST, required=True),
)
async def place_robot(request: Request, gateway: TheGateway, robot: RobotQuery = None) -> Response:
    """Move the robot to a pose through RViz's `initialpose` topic."""
    pose = read_pose(await read_json(request))
    return json_response(await gateway.simulators.place(_robot(gateway, robot), pose))


@router.put(
    "/faults/{fault}",
    response_model=Simulator,
    responses=problems(400, 404, 408, 413, 415, 422, 503, 504),
    openapi_extra=body(FAULT_REQUEST, required=True),
)
async def switch_fault(fault: FaultPath, request: Request, gateway: TheGateway, robot: RobotQuery = None) -> Response:
    """Switch a fault on or off."""
    active = read_object(await read_json(request), "active").get("active")
    if not isinstance(active, bool):
        raise InvalidField([FieldError("active", "true or false", got(active))])
    return json_response(await gateway.simulators.switch(_robot(gateway, robot), fault, active=active))
