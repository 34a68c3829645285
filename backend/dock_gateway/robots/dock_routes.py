"""`/docks`: the docks that a robot's docking server knows by name."""

from fastapi import APIRouter, Depends
from starlette.responses import Response

from dock_gateway.core.grant import Role
from dock_gateway.http.operation import Scope, operation
from dock_gateway.http.problems import problems
from dock_gateway.http.requests import RobotQuery, TheGateway, json_response, known_query
from dock_gateway.robots.schema import DockList

router = APIRouter(tags=["Dock"], prefix="/docks", dependencies=[Depends(known_query("robot"))])


@router.get("", response_model=DockList, responses=problems(404, 422, 503))
@operation(Role.VIEWER, Scope.DOCK)
async def list_docks(gateway: TheGateway, robot: RobotQuery = None) -> Response:
    """List the docks of the robot's docking server, in its order. There are none if it knows no docks by name."""
    action = await gateway.docking_action("dock", robot)
    return json_response(await gateway.docks.document(action.name, action.family))
