"""Services of ROS nodes: those that only read, and those that the settings name, are called."""

from dataclasses import dataclass
from typing import Any

from dock_gateway.core.access import Principal
from dock_gateway.core.grant import Role
from dock_gateway.graph.service_calls import ServiceCalls, ServiceResponse
from dock_gateway.http.operation import Scope, operation
from dock_gateway.http.parts import Parts


@dataclass(frozen=True)
class CallService:
    """A call of a service.

    Attributes:
        service: Absolute name of the service.
        request: The request, or its fields as decoded JSON; those that are left out get their default.
        type: Its type; needed if it has several.
        timeout: Seconds to wait for the response.
    """

    service: str
    request: Any
    type: str | None = None
    timeout: float = 5.0


@operation(Role.OPERATOR, Scope.SERVICE, errors=(409, 429, 502, 504))
async def call_service(parts: Parts, principal: Principal, order: CallService) -> ServiceResponse:
    """Call a service of a ROS node. Return its response.

    Raises:
        GatewayError: As `ServiceCalls.call`.
    """
    return await parts[ServiceCalls].call(
        order.service, order.request, type_name=order.type, timeout=order.timeout, grant=principal.grant
    )
