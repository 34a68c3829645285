"""`/gateways`: which gateways share the database, and which robots each of them serves."""

from fastapi import APIRouter

from dock_gateway.core.grant import Role
from dock_gateway.gateways.gateways import Gateways
from dock_gateway.gateways.schema import GatewayList
from dock_gateway.http.openapi import UNSTABLE
from dock_gateway.http.operation import Audit, Scope, operation
from dock_gateway.http.parts import Part
from dock_gateway.http.requests import Answer, json_response
from dock_gateway.http.route import ApiRoute

router = APIRouter(route_class=ApiRoute, tags=["Robots"])


@router.get("/gateways", openapi_extra=UNSTABLE)
@operation(Role.VIEWER, Scope.EVERY, Audit.NEVER)
async def list_gateways(gateways: Part[Gateways]) -> Answer[GatewayList]:
    """List the gateways that share the database, this one first, and the robots that each serves."""
    return json_response(gateways.document())
