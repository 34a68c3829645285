"""`/simulator`: manual control of a simulated robot. A real robot has no simulator."""

import math
from typing import Annotated

from fastapi import APIRouter, Path

from dock_gateway.core.grant import Role
from dock_gateway.core.scene import Pose
from dock_gateway.extensions.simulator.controls import SimulatorControls
from dock_gateway.extensions.simulator.schema import FaultBody, PlaceBody
from dock_gateway.http.bodies import Body
from dock_gateway.http.openapi import UNSTABLE
from dock_gateway.http.operation import Scope, operation
from dock_gateway.http.parts import Part
from dock_gateway.http.requests import Answer, RobotQuery, json_response
from dock_gateway.http.route import ApiRoute
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway.robots.schema import Simulator
from dock_gateway.robots.simulator import Fault

router = APIRouter(route_class=ApiRoute, tags=["Simulator"], prefix="/simulator")

FaultPath = Annotated[Fault, Path(description="What breaks")]


@router.get("", openapi_extra=UNSTABLE)
@operation(Role.VIEWER, Scope.ROBOT, errors=(404,))
async def get_simulator(
    controls: Part[SimulatorControls], robots: Part[RobotRegistry], robot: RobotQuery = None
) -> Answer[Simulator]:
    """Return the active faults, and whether the robot touches its dock and is charged there."""
    return json_response(controls.get(robots.get(robot).namespace).document())


@router.post("/reset", openapi_extra=UNSTABLE)
@operation(Role.OPERATOR, Scope.ROBOT, errors=(404, 504))
async def reset_simulator(
    controls: Part[SimulatorControls], robots: Part[RobotRegistry], robot: RobotQuery = None
) -> Answer[Simulator]:
    """Move the robot to its start pose, restore its battery, and clear every fault."""
    return json_response(await controls.reset(robots.get(robot).namespace))


@router.post("/place", openapi_extra=UNSTABLE)
@operation(Role.OPERATOR, Scope.ROBOT, errors=(404, 504))
async def place_robot(
    body: Body[PlaceBody], controls: Part[SimulatorControls], robots: Part[RobotRegistry], robot: RobotQuery = None
) -> Answer[Simulator]:
    """Move the robot to a pose through RViz's `initialpose` topic."""
    pose = Pose(body.x, body.y, math.remainder(body.theta, math.tau))
    return json_response(await controls.place(robots.get(robot).namespace, pose))


@router.put("/faults/{fault}", openapi_extra=UNSTABLE)
@operation(Role.OPERATOR, Scope.ROBOT, errors=(404, 504))
async def switch_fault(
    fault: FaultPath,
    body: Body[FaultBody],
    controls: Part[SimulatorControls],
    robots: Part[RobotRegistry],
    robot: RobotQuery = None,
) -> Answer[Simulator]:
    """Switch a fault on or off."""
    return json_response(await controls.switch(robots.get(robot).namespace, fault, active=body.active))
