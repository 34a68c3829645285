"""The API of the hub itself: its sites, and what spans all of them."""

from dataclasses import replace
from typing import Annotated, cast

from fastapi import APIRouter, Path, Request
from starlette.responses import Response

from dock_gateway import __version__
from dock_gateway.access.authorization import sees_all
from dock_gateway.audit.trail import audited
from dock_gateway.core.errors import NotFound, not_covered
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.goal import encode
from dock_gateway.core.grant import UNLIMITED, Role
from dock_gateway.core.versions import Condition
from dock_gateway.fleet.schema import AcknowledgementBody
from dock_gateway.http.bodies import SignedBody
from dock_gateway.http.operation import Scope, carries_out, operation, public_operation
from dock_gateway.http.parts import AllParts, Part, Parts
from dock_gateway.http.principal import TheGrant, principal_of
from dock_gateway.http.requests import WITH_POSITION, Answer, BelowQuery, RobotQuery, json_response, list_response
from dock_gateway.http.resource import ChangeCondition, Item, item_response, removed
from dock_gateway.http.route import ApiRoute
from dock_gateway.sites.broker import Broker
from dock_gateway.sites.names import site_grant
from dock_gateway.sites.tunnel.failures import SiteFailed
from dock_gateway.storage import History
from dock_hub.fields import Document, ForeignDocumentError
from dock_hub.overview import Overview, servers_of, stop_of
from dock_hub.renaming import read_alerts
from dock_hub.schema import HubHealth, HubReadiness, SiteAlert, SiteAlertList, SiteInfo, SiteList, SiteRobotList
from dock_hub.site_client import JSON, SiteRequest
from dock_hub.sites import Sites
from dock_hub.stop_outcomes import read_problem
from dock_hub.stops import Stops

router = APIRouter(route_class=ApiRoute)

SiteName = Annotated[str, Path(description="Name of the site, such as `berlin`")]
AlertId = Annotated[str, Path(description="`id` of the alert")]


@router.get("/sites", tags=["Sites"])
@operation(Role.VIEWER, Scope.LISTED)
async def list_sites(overview: Part[Overview], grant: TheGrant) -> Answer[SiteList]:
    """List the sites of which the user may see any robot, by name."""
    return json_response({"sites": overview.site_documents(grant)})


@router.get("/sites/{site}", tags=["Sites"])
@operation(Role.VIEWER, Scope.LISTED, errors=(404,))
async def get_site(site: SiteName, sites: Part[Sites], grant: TheGrant) -> Answer[SiteInfo]:
    """Return one site."""
    return json_response(sites.document(site, grant))


@router.delete("/sites/{site}", tags=["Sites"], status_code=204)
@operation(Role.ADMIN, Scope.EVERY, errors=(404,))
async def forget_site(site: SiteName, sites: Part[Sites], stops: Part[Stops]) -> Response:
    """Forget a site, and which gateway has its name: the next one to come with that name has it.

    A site that is still there comes back by itself. Its goals stay in the history; a stop that it has not confirmed is
    dropped.
    """
    await sites.forget(site)
    await stops.forget(site)
    return Response(status_code=204)


@router.get("/robots", tags=["Robots"], responses=WITH_POSITION)
@operation(Role.VIEWER, Scope.LISTED, errors=(404,))
async def list_robots(
    overview: Part[Overview], fanout: Part[Fanout], grant: TheGrant, robot: BelowQuery = None
) -> Answer[SiteRobotList]:
    """List the robots of all sites, or only those at or below `robot`: `/berlin` is a whole site.

    Those of a site that is not connected are as they were then.
    """
    position = fanout.position  # before the list
    return list_response({"robots": overview.find_robots(grant, robot)}, position)


@router.get("/alerts", tags=["Alerts"])
@operation(Role.VIEWER, Scope.LISTED)
async def list_alerts(overview: Part[Overview], grant: TheGrant) -> Answer[SiteAlertList]:
    """List the active alerts of all sites, and those about sites: critical ones first, then oldest first."""
    return json_response({"alerts": overview.documents(grant)})


@router.get("/alerts/{alert_id}", tags=["Alerts"])
@operation(Role.VIEWER, Scope.ALERT)
async def get_alert(alert_id: AlertId, overview: Part[Overview], grant: TheGrant) -> Item[SiteAlert]:
    """Return an active alert. Its version changes with its acknowledgement."""
    return item_response(overview.get(alert_id, grant))


@operation(Role.OPERATOR, Scope.ALERT, errors=(504,))
async def acknowledge_alert(
    alert_id: str, request: Request, parts: Parts, by: str | None, condition: Condition
) -> Response:
    """Acknowledge an alert, or with `by` None withdraw that: one of a site at that site, as its user."""
    overview, principal = parts[Overview], principal_of(request)
    alert = overview.get(alert_id, principal.grant)
    audited(request, robot=alert["robot"])
    if overview.is_own(alert_id):
        return _acknowledged(await overview.acknowledge(alert_id, by, condition), by)
    site, _, own_id = alert_id.partition(".")
    client, grant = parts[Sites].client(site, principal.grant), site_grant(principal.grant, site)
    if grant is None:
        raise NotFound(f"there is no alert {alert_id[:60]}", code="alert_not_found")
    method, sent = ("DELETE", b"") if by is None else ("PUT", encode({"by": by}))
    path = f"/alerts/{own_id}/acknowledgement"
    headers = [*JSON, *((name, value) for name, value in request.scope["headers"] if name == b"if-match")]
    asked = SiteRequest(method, path, body=sent, user=principal.name, grant=grant, headers=headers)
    answer = await client.ask(asked)
    if answer.status == 204:
        return Response(status_code=204)
    if answer.status != 200:
        raise read_problem(site, answer.body, answer.status)
    try:
        (changed,) = read_alerts(site, [answer.json()])
    except ForeignDocumentError as error:
        raise SiteFailed(f"the site {site} has answered with something that is no alert: {error}", site=site) from None
    return item_response(alert | {"acknowledged": changed["acknowledged"], "etag": changed["etag"]})


def _acknowledged(alert: Document, by: str | None) -> Response:
    return Response(status_code=204) if by is None else item_response(alert)


@router.put("/alerts/{alert_id}/acknowledgement", tags=["Alerts"])
@carries_out(acknowledge_alert)
async def acknowledge(
    alert_id: AlertId,
    body: SignedBody[AcknowledgementBody],
    request: Request,
    parts: AllParts,
    condition: ChangeCondition,
) -> Item[SiteAlert]:
    """Acknowledge an alert: one of a site at that site, which decides whether the user may."""
    answer = await acknowledge_alert(alert_id, request, parts, body.by, condition)
    return cast("Item[SiteAlert]", answer)  # or what the site has refused it with


@router.delete("/alerts/{alert_id}/acknowledgement", tags=["Alerts"], status_code=204)
@carries_out(acknowledge_alert)
async def withdraw_acknowledgement(
    alert_id: AlertId, request: Request, parts: AllParts, condition: ChangeCondition
) -> Response:
    """Withdraw an acknowledgement. Succeeds even if there is none."""
    return await removed(acknowledge_alert(alert_id, request, parts, None, condition))


@router.get("/healthz", tags=["Health"])
@public_operation(any_query=True)
async def healthz(broker: Part[Broker], fanout: Part[Fanout]) -> Answer[HubHealth]:
    """Report that the hub answers. It has no node on a ROS graph, and no hub of its own."""
    health = {
        "status": "ok",
        "version": __version__,
        "node": "",
        "ros": {},
        "subscribers": len(fanout),
        "hub": None,
        "broker_connected": broker.connected,
    }
    return json_response(health)


@router.get("/readyz", tags=["Health"], responses={503: {"model": HubReadiness}})
@public_operation(errors=(404,))
async def readyz(request: Request, parts: AllParts, robot: RobotQuery = None) -> Answer[HubReadiness]:
    """Report whether the hub reaches its database and the NATS server.

    With `robot`, whether the docking server of that robot is available and answers, too. Who stopped which robots, the
    robots, and the last error of the history are only shown to users without limits.
    """
    overview, stats, connected = parts[Overview], parts[History].stats(), parts[Broker].connected
    sees_everything = await sees_all(request)
    if robot is not None and not sees_everything:
        raise not_covered("robots by name here")
    name, robots = overview.find(robot), overview.find_robots(UNLIMITED, robot)
    dock, undock = servers_of(robots, name).values()
    stop, names = stop_of(robots), overview.namespaces()
    if not sees_everything:
        stats, stop, names = replace(stats, last_error=None), {**stop, "by": None, "robots": []}, []
    ready = connected and stats.database_reachable
    if robot is not None:
        ready = ready and dock["available"] and dock["answering"]
    document = {
        "ready": ready,
        "robot": name,
        "robots": names,
        "hint": None,
        "settings": [],
        "problems": [],
        "action_server": dock,
        "undock_server": undock,
        "history": stats,
        "stop": stop,
        "broker_connected": connected,
        "sites": parts[Sites].count(),
    }
    return json_response(document, 200 if ready else 503)
