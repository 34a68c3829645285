"""`GET /odometer`."""

from fastapi import APIRouter

from dock_gateway.core.grant import Role
from dock_gateway.http.operation import Scope, operation
from dock_gateway.http.parts import Part
from dock_gateway.http.requests import Answer, RobotQuery, json_response
from dock_gateway.http.route import ApiRoute
from dock_gateway.http.schema import RosName, Schema
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway_odometer.odometers import Odometers

router = APIRouter(route_class=ApiRoute, tags=["Odometer"])


class Distance(Schema):
    """What a robot has driven since the odometer counts, in metres."""

    robot: RosName
    metres: float


@router.get("/odometer")
@operation(Role.VIEWER, Scope.ROBOT, errors=(404,))
async def get_odometer(
    odometers: Part[Odometers], robots: Part[RobotRegistry], robot: RobotQuery = None
) -> Answer[Distance]:
    """Return how far a robot has driven."""
    return json_response(odometers.document(robots.get(robot).namespace))
