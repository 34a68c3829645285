"""`/calibration`: the docking server measures where its docked robot is."""

from fastapi import APIRouter, Depends
from starlette.responses import Response

from dock_gateway.core.grant import Role
from dock_gateway.http.operation import Scope, operation
from dock_gateway.http.parts import Part
from dock_gateway.http.problems import problems
from dock_gateway.http.requests import RobotQuery, json_response, known_query
from dock_gateway.robots.calibration import Calibrations
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway.robots.schema import Calibration, CalibrationService

router = APIRouter(tags=["Robots"], dependencies=[Depends(known_query("robot"))])


@router.get("/calibration", response_model=CalibrationService, responses=problems(404, 422, 503))
@operation(Role.VIEWER, Scope.ROBOT)
async def get_calibration(
    calibrations: Part[Calibrations], robots: Part[RobotRegistry], robot: RobotQuery = None
) -> Response:
    """Return whether the robot's docking server can calibrate its dock."""
    return json_response(await calibrations.document(robots.get(robot).namespace))


@router.post("/calibration", response_model=Calibration, responses=problems(404, 409, 422, 503, 504))
@operation(Role.SUPERVISOR, Scope.ROBOT)
async def calibrate_dock(
    calibrations: Part[Calibrations], robots: Part[RobotRegistry], robot: RobotQuery = None
) -> Response:
    """Measure where the docked robot stands, as seen from the marker, and use that from now on. Nothing moves.

    The answer comes after 3 to 10 s.
    """
    return json_response(await calibrations.calibrate(robots.get(robot).namespace))
