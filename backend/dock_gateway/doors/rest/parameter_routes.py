"""`/nodes/…/parameters`: the parameters of any node, to read, and to set where the settings name the node."""

from typing import Annotated

from fastapi import APIRouter, Query, Request

from dock_gateway.audit.trail import audited
from dock_gateway.core.errors import FieldError, InvalidField, got
from dock_gateway.doors.rest.service_routes import describe_use
from dock_gateway.graph.call_schema import NodeParameters, ParameterChanges
from dock_gateway.graph.parameters import Parameters
from dock_gateway.http.openapi import body
from dock_gateway.http.operation import carries_out
from dock_gateway.http.parts import AllParts, Part
from dock_gateway.http.principal import ThePrincipal
from dock_gateway.http.requests import Answer, GraphName, json_response, read_json
from dock_gateway.http.route import ApiRoute
from dock_gateway.operations import parameters as operations

router = APIRouter(route_class=ApiRoute, tags=["Parameters"], prefix="/nodes")

AtOnceQuery = Annotated[bool, Query(description="Whether all parameters are set or none")]


@router.get("/{node:graph_name}/parameters")
@carries_out(operations.get_parameters)
async def get_parameters(
    node: GraphName, parameters: Part[Parameters], parts: AllParts, principal: ThePrincipal
) -> Answer[NodeParameters]:
    """Return all parameters of a node: their values, types, ranges and descriptions, and whether they may be set."""
    name = f"/{node}"
    found = await operations.get_parameters(parts, principal, name)
    return json_response(
        {
            "node": name,
            "set": describe_use(lambda: parameters.require_allowed(name)),
            "parameters": [parameter.document() for parameter in found],
        }
    )


@router.patch(
    "/{node:graph_name}/parameters",
    openapi_extra=body({"type": "object", "description": "New values by name"}, required=True),
)
@carries_out(operations.set_parameters)
async def set_parameters(
    node: GraphName,
    request: Request,
    parts: AllParts,
    principal: ThePrincipal,
    *,
    at_once: AtOnceQuery = True,
) -> Answer[ParameterChanges]:
    """Set parameters of a node. Types and ranges are checked before anything is sent.

    With `at_once=false` each is set by itself: those that the node refuses have a `reason`, the others are set.
    """
    name = f"/{node}"
    values = await read_json(request)
    if not isinstance(values, dict):
        raise InvalidField([FieldError("", "an object with parameters by name", got(values))])
    order = operations.SetParameters(name, values, at_once)
    audited(request, subject=order.subject)
    changes = await operations.set_parameters(parts, principal, order)
    return json_response({"node": name, "parameters": [change.document() for change in changes]})
