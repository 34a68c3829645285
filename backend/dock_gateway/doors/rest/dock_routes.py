"""`/docks`: the docks that a robot's docking server knows."""

from fastapi import APIRouter

from dock_gateway.core.grant import Role
from dock_gateway.goals.docks import Docks
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.http.operation import Scope, operation
from dock_gateway.http.parts import Part
from dock_gateway.http.requests import Answer, RobotQuery, json_response
from dock_gateway.http.route import ApiRoute
from dock_gateway.robots.schema import DockList

router = APIRouter(route_class=ApiRoute, tags=["Dock"])


@router.get("/docks")
@operation(Role.VIEWER, Scope.DOCK)
async def list_docks(actions: Part[ActionRegistry], docks: Part[Docks], robot: RobotQuery = None) -> Answer[DockList]:
    """List the docks of the robot's docking server, in its order. There are none if it knows no docks by name."""
    action = await actions.find_docking("dock", robot)
    return json_response(await docks.document(action.name, action.family, action.default_dock))
