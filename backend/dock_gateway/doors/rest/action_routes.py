"""`/actions`: the actions on the graph. Their goals are in `sent_goals`."""

from typing import Annotated

from fastapi import APIRouter, Query

from dock_gateway.core.grant import Role
from dock_gateway.goals.action_schema import ActionInfo, ActionList
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.http.operation import Scope, carries_out, operation
from dock_gateway.http.parts import AllParts, Part
from dock_gateway.http.principal import ThePrincipal
from dock_gateway.http.requests import Answer, GraphName, json_response
from dock_gateway.http.route import ApiRoute
from dock_gateway.operations import fleet

router = APIRouter(route_class=ApiRoute, tags=["Actions"], prefix="/actions")

HiddenQuery = Annotated[bool, Query(description="Whether to list hidden actions, too")]


@router.get("")
@carries_out(fleet.list_actions)
async def list_actions(parts: AllParts, principal: ThePrincipal, *, hidden: HiddenQuery = False) -> Answer[ActionList]:
    """List every action on the graph. If an action's interface package is missing, `hint` says what to install.

    As in ROS, an action is hidden if a part of its name begins with `_`. Those that dock or undock a robot are listed.
    """
    return json_response({"actions": await fleet.list_actions(parts, principal, hidden=hidden)})


@router.get("/{name:graph_name}")
@operation(Role.VIEWER, Scope.ACTION)
async def get_action(name: GraphName, actions: Part[ActionRegistry]) -> Answer[ActionInfo]:
    """Return one action."""
    return json_response((await actions.find(f"/{name}")).document())
