"""`/gateways`: which gateways share the database, and which robots each of them serves."""

from fastapi import APIRouter
from starlette.responses import Response

from dock_gateway.core.grant import Role
from dock_gateway.gateways.claims import Gateways
from dock_gateway.gateways.schema import GatewayList
from dock_gateway.http.operation import Audit, Scope, operation
from dock_gateway.http.parts import Part
from dock_gateway.http.problems import problems
from dock_gateway.http.requests import NO_QUERY, json_response

router = APIRouter(tags=["Robots"])


@router.get("/gateways", response_model=GatewayList, responses=problems(422), dependencies=[NO_QUERY])
@operation(Role.VIEWER, Scope.EVERY, Audit.NEVER)
async def list_gateways(gateways: Part[Gateways]) -> Response:
    """List the gateways that share the database, this one first, and the robots that each serves."""
    return json_response(gateways.document())
