"""`/services`: what any service on the ROS graph takes and gives, and calls of those that the settings name."""

from collections.abc import Callable
from typing import Annotated, Any

from fastapi import APIRouter, Query, Request

from dock_gateway.core.errors import GatewayError, NotAllowed
from dock_gateway.core.goal import fragment
from dock_gateway.core.grant import Role
from dock_gateway.graph.call_schema import ServiceAnswer, ServiceInfo
from dock_gateway.graph.service_calls import ServiceCalls
from dock_gateway.http.openapi import body
from dock_gateway.http.operation import Scope, carries_out, operation
from dock_gateway.http.parts import AllParts, Part
from dock_gateway.http.principal import TheGrant, ThePrincipal
from dock_gateway.http.requests import Answer, GraphName, json_response, read_json
from dock_gateway.http.route import ApiRoute
from dock_gateway.operations import services
from dock_gateway.ros.messages.codec import codec
from dock_gateway.ros.messages.schema import DIALECT
from dock_gateway.ros.messages.types import MessageClass

router = APIRouter(route_class=ApiRoute, tags=["Services"], prefix="/services")

TypeQuery = Annotated[
    str | None, Query(alias="type", max_length=300, description="The type, if there are several on the ROS graph")
]
TimeoutQuery = Annotated[float, Query(gt=0, le=300, description="Seconds to wait for the response")]


def describe_use(require: Callable[[], None]) -> dict[str, Any]:
    """Return whether something may be used, as the API shows it, by the check that refuses it."""
    try:
        require()
    except NotAllowed as error:
        return {"allowed": False, "reason": error.detail}
    return {"allowed": True, "reason": None}


def message_schema(message_class: MessageClass, *, complete: bool) -> dict[str, Any]:
    """Return the JSON Schema of a message, a request or a response."""
    return {"$schema": DIALECT, **codec(message_class).schema(complete=complete)}


@router.get("/{service:graph_name}")
@operation(Role.VIEWER, Scope.LOOKED_AT)
async def get_service(
    service: GraphName, calls: Part[ServiceCalls], grant: TheGrant, *, type_name: TypeQuery = None
) -> Answer[ServiceInfo]:
    """Return the type of a service, the JSON Schema of its request and response, and whether it may be called."""
    found = await calls.find(f"/{service}", type_name, grant)
    document: dict[str, Any] = {
        "service": found.name,
        "type": found.type,
        "types": found.types,
        "reads": found.reads,
        "hint": None,
        "call": describe_use(lambda: calls.require_allowed(found)),
        "request": None,
        "response": None,
    }
    try:
        kind = await calls.load(found)
    except GatewayError as error:
        document["hint"] = error.detail
    else:
        document["request"] = message_schema(kind.Request, complete=False)
        document["response"] = message_schema(kind.Response, complete=True)
    return json_response(document)


@router.post(
    "/{service:graph_name}",
    openapi_extra=body({"type": "object", "description": "The request's own fields"}, required=True),
)
@carries_out(services.call_service)
async def call_service(
    service: GraphName,
    request: Request,
    parts: AllParts,
    principal: ThePrincipal,
    *,
    type_name: TypeQuery = None,
    timeout_s: TimeoutQuery = 5.0,
) -> Answer[ServiceAnswer]:
    """Call a service and return its response. The body holds the fields of the request; `{}` sends its defaults.

    A response that does not come in time is not the end of the call: the service may still carry it out.
    """
    name = f"/{service}"
    fields = await read_json(request)
    answer = await services.call_service(parts, principal, services.CallService(name, fields, type_name, timeout_s))
    response = await parts[ServiceCalls].encode(name, answer)
    return json_response({"service": name, "type": answer.type, "response": fragment(response)})
