"""`/healthz` and `/readyz`, for supervisors and load balancers."""

from dataclasses import replace

from fastapi import APIRouter, Request
from starlette.responses import Response

from dock_gateway import __version__
from dock_gateway.core.errors import GatewayError, Unavailable
from dock_gateway.ros.bridge import ros_environment
from dock_gateway.web.access import identify
from dock_gateway.web.requests import TheGateway, json_response
from dock_gateway.web.schemas.health import Health, Readiness

router = APIRouter(tags=["Health"])


@router.get("/healthz", response_model=Health, responses={503: {"model": Health}})
async def healthz(gateway: TheGateway) -> Response:
    """Report whether the ROS thread is alive and responsive."""
    try:
        await gateway.bridge.call(lambda: None, timeout=1.0)
        alive = True
    except Unavailable:
        alive = False
    health = {
        "status": "ok" if alive else "ros_unavailable",
        "version": __version__,
        "node": gateway.settings.resolve(gateway.settings.node_name),
        "ros": ros_environment(),
        "subscribers": len(gateway.hub),
    }
    return json_response(health, 200 if alive else 503)


@router.get("/readyz", response_model=Readiness, responses={503: {"model": Readiness}})
async def readyz(request: Request, gateway: TheGateway) -> Response:
    """Report whether the action server is available and answers, and the state of the history.

    Who stopped which robots, and the last error of the history, are only shown to users without limits.

    A failing history does not affect readiness: it holds up no goal. Nor does a latched stop: the gateway is ready to
    release it.
    """
    state, undock = gateway.actions.servers_of(gateway.robots.default_namespace)
    dock = gateway.actions.get(state.action_name)
    ready = gateway.bridge.alive and dock is not None and dock.watch.ready
    history, stop = gateway.history.stats(), gateway.stopper.state()
    if not await _sees_everything(request):
        history, stop = replace(history, last_error=None), {**stop, "by": None, "robots": []}
    document = {"ready": ready, "action_server": state, "undock_server": undock, "history": history, "stop": stop}
    return json_response(document, 200 if ready else 503)


async def _sees_everything(request: Request) -> bool:
    try:
        return not (await identify(request)).grant.limited
    except GatewayError:
        return False
