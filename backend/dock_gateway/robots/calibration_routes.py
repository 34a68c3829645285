"""`/calibration`: the docking server measures where its docked robot is."""

from fastapi import APIRouter

from dock_gateway.core.grant import Role
from dock_gateway.http.operation import Scope, operation
from dock_gateway.http.parts import Part
from dock_gateway.http.requests import Answer, RobotQuery, json_response
from dock_gateway.http.route import ApiRoute
from dock_gateway.robots.calibration import Calibrations
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway.robots.schema import Calibration, CalibrationService

router = APIRouter(route_class=ApiRoute, tags=["Robots"])


@router.get("/calibration")
@operation(Role.VIEWER, Scope.ROBOT, errors=(404,))
async def get_calibration(
    calibrations: Part[Calibrations], robots: Part[RobotRegistry], robot: RobotQuery = None
) -> Answer[CalibrationService]:
    """Return whether the robot's docking server can calibrate its dock."""
    return json_response(await calibrations.document(robots.get(robot).namespace))


@router.post("/calibration")
@operation(Role.SUPERVISOR, Scope.ROBOT, errors=(404, 409, 501, 504))
async def calibrate_dock(
    calibrations: Part[Calibrations], robots: Part[RobotRegistry], robot: RobotQuery = None
) -> Answer[Calibration]:
    """Measure where the docked robot stands, as seen from the marker, and use that from now on. Nothing moves.

    The answer comes after 3 to 10 s.
    """
    return json_response(await calibrations.calibrate(robots.get(robot).namespace))
