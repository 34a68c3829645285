"""`/healthz` and `/readyz` of a gateway, for supervisors and load balancers."""

from dataclasses import replace

from fastapi import APIRouter, Request

from dock_gateway import __version__
from dock_gateway.access.authorization import sees_all
from dock_gateway.core.errors import Unavailable, not_covered
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.grant import UNLIMITED
from dock_gateway.fleet.alert_board import AlertBoard
from dock_gateway.goals.docking_hints import DockingHints
from dock_gateway.goals.registry import ActionRegistry
from dock_gateway.http.further_ways import FurtherWays
from dock_gateway.http.operation import public_operation
from dock_gateway.http.parts import AllParts, Part
from dock_gateway.http.requests import Answer, RobotQuery, json_response
from dock_gateway.http.route import ApiRoute
from dock_gateway.observability.schema import Health, Readiness
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway.ros.bridge import Bridge, ros_environment
from dock_gateway.settings import Settings
from dock_gateway.stop.stopper import Stopper
from dock_gateway.storage import History

router = APIRouter(route_class=ApiRoute, tags=["Health"])


@router.get("/healthz", responses={503: {"model": Health}})
@public_operation(any_query=True)
async def healthz(
    bridge: Part[Bridge], settings: Part[Settings], fanout: Part[Fanout], ways: Part[FurtherWays]
) -> Answer[Health]:
    """Report whether the ROS thread is alive and responsive, and at a site whether its hub reaches it.

    A site works without its hub, so that is no fault of it.
    """
    try:
        await bridge.call(lambda: None, timeout=1.0)
        alive = True
    except Unavailable:
        alive = False
    health = {
        "status": "ok" if alive else "ros_unavailable",
        "version": __version__,
        "node": settings.resolve(settings.node_name),
        "ros": ros_environment(),
        "subscribers": len(fanout),
        "hub": next((way.document() for way in ways), None),
    }
    return json_response(health, 200 if alive else 503)


@router.get("/readyz", responses={503: {"model": Readiness}})
@public_operation(errors=(404,))
async def readyz(request: Request, parts: AllParts, robot: RobotQuery = None) -> Answer[Readiness]:
    """Report whether the docking server of a robot is available and answers, and the state of the history.

    Who stopped which robots, the robots that were found, and the last error of the history are only shown to users
    without limits.

    A failing history does not affect readiness: it holds up no goal. Nor does a latched stop: the gateway is ready to
    release it.

    Without `robot`, it is about the configured robot, or the first one where there is none.
    """
    sees_everything = await sees_all(request)
    if robot is not None and not sees_everything:
        raise not_covered("robots by name here")
    name = parts[RobotRegistry].find(robot)
    state, undock = parts[ActionRegistry].servers_of(name)
    dock = parts[ActionRegistry].get(state.action_name)
    ready = parts[Bridge].alive and dock is not None and dock.watch.ready
    history, stop = parts[History].stats(), parts[Stopper].state(name)
    hint, robots, found = None, list[str](), list[str]()
    if sees_everything:
        hint = None if state.available else parts[DockingHints].hint(name, UNLIMITED)
        robots = [sight.robot for sight in parts[DockingHints].sights() if sight.battery or sight.dock or sight.undock]
        found = [alert.detail for alert in parts[AlertBoard].of_graph(name)]
    else:
        history, stop = replace(history, last_error=None), {**stop, "by": None, "robots": []}
    document = {
        "ready": ready,
        "robot": name,
        "robots": robots,
        "hint": None if hint is None else hint.detail,
        "settings": [] if hint is None else hint.settings,
        "problems": found,
        "action_server": state,
        "undock_server": undock,
        "history": history,
        "stop": stop,
    }
    return json_response(document, 200 if ready else 503)
