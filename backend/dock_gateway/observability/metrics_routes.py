"""`/metrics`, for Prometheus."""

from fastapi import APIRouter, Request
from prometheus_client.exposition import CONTENT_TYPE_PLAIN_0_0_4
from starlette.responses import PlainTextResponse, Response

from dock_gateway.core.grant import Role
from dock_gateway.http.operation import Scope, operation
from dock_gateway.http.parts import Part
from dock_gateway.http.route import ApiRoute
from dock_gateway.observability.metrics import Metrics

router = APIRouter(route_class=ApiRoute, tags=["Health"])


@router.get("/metrics", response_class=PlainTextResponse)
@operation(Role.VIEWER, Scope.EVERY, any_query=True)
async def metrics(request: Request, metrics: Part[Metrics]) -> Response:
    """Return the gateway's metrics in Prometheus' text format."""
    return Response(await metrics.text(request.app.state.requests), media_type=CONTENT_TYPE_PLAIN_0_0_4)
