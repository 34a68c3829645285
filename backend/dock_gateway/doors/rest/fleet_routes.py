"""`/robots`: a summary of every robot, and its label. `/alerts`: the active alerts and who acknowledged them."""

from typing import Annotated

from fastapi import APIRouter, Path, Request
from starlette.responses import Response

from dock_gateway.audit.trail import audited
from dock_gateway.core.fanout import Fanout
from dock_gateway.core.grant import Role
from dock_gateway.core.namespace import read_namespace
from dock_gateway.fleet.schema import AcknowledgementBody, Alert, AlertList, Label, LabelBody, RobotList
from dock_gateway.http.bodies import Body, SignedBody
from dock_gateway.http.operation import Audit, Scope, carries_out, operation
from dock_gateway.http.parts import AllParts, Parts
from dock_gateway.http.principal import ThePrincipal
from dock_gateway.http.requests import WITH_POSITION, Answer, AnyRobotQuery, RobotQuery, json_response, list_response
from dock_gateway.http.resource import ChangeCondition, Item, SetCondition, item_response, removed
from dock_gateway.http.route import ApiRoute
from dock_gateway.operations import fleet
from dock_gateway.robots.labels import Labels, RobotLabel
from dock_gateway.robots.robots import Robots

router = APIRouter(route_class=ApiRoute)


@router.get("/robots", tags=["Robots"], responses=WITH_POSITION)
@carries_out(fleet.list_robots)
async def list_robots(parts: AllParts, principal: ThePrincipal, robot: AnyRobotQuery = None) -> Answer[RobotList]:
    """List every robot that was found, or only the one given by `robot`. A stream goes on after `Event-Id`."""
    position = parts[Fanout].position  # before the list
    return list_response({"robots": await fleet.list_robots(parts, principal, robot)}, position)


@router.get("/label", tags=["Robots"])
@operation(Role.VIEWER, Scope.ROBOT, Audit.NEVER)
async def get_label(parts: AllParts, robot: RobotQuery = None) -> Item[Label]:
    """Return the display name and the groups of a robot, which need not be there."""
    return _answer_label(parts, _name_of(parts, robot))


@router.put("/label", tags=["Robots"])
@carries_out(fleet.label_robot)
async def label_robot(
    label: Body[LabelBody],
    request: Request,
    parts: AllParts,
    principal: ThePrincipal,
    condition: SetCondition,
    *,
    robot: RobotQuery = None,
) -> Item[Label]:
    """Replace the display name and the groups of a robot, at every gateway that shares the history.

    `null` without groups removes the label. A label outlives restarts, and may be set before the robot appears.
    """
    namespace = _name_of(parts, robot)
    audited(request, robot=namespace)
    await fleet.label_robot(parts, principal, namespace, RobotLabel(label.display_name, label.groups), condition)
    return _answer_label(parts, namespace)


def _name_of(parts: Parts, robot: str | None) -> str:
    return parts[Robots].default_namespace if robot is None else read_namespace(robot)


def _answer_label(parts: Parts, robot: str) -> Item[Label]:
    labels = parts[Labels]
    return item_response({"robot": robot, "etag": labels.etag(robot), **vars(labels.get(robot))})


AlertId = Annotated[str, Path(description="`id` of the alert")]


@router.get("/alerts", tags=["Alerts"])
@carries_out(fleet.list_alerts)
async def list_alerts(parts: AllParts, principal: ThePrincipal) -> Answer[AlertList]:
    """List the active alerts: critical ones first, then oldest first."""
    return json_response({"alerts": await fleet.list_alerts(parts, principal)})


@router.get("/alerts/{alert_id}", tags=["Alerts"])
@carries_out(fleet.get_alert)
async def get_alert(alert_id: AlertId, parts: AllParts, principal: ThePrincipal) -> Item[Alert]:
    """Return an active alert. Its version changes with its acknowledgement."""
    return item_response(await fleet.get_alert(parts, principal, alert_id))


@router.put("/alerts/{alert_id}/acknowledgement", tags=["Alerts"])
@carries_out(fleet.acknowledge_alert)
async def acknowledge(
    alert_id: AlertId,
    body: SignedBody[AcknowledgementBody],
    parts: AllParts,
    principal: ThePrincipal,
    condition: ChangeCondition,
) -> Item[Alert]:
    """Acknowledge an alert. This holds at every gateway that shares the history, until the alert clears."""
    return item_response(await fleet.acknowledge_alert(parts, principal, alert_id, body.by, condition))


@router.delete("/alerts/{alert_id}/acknowledgement", tags=["Alerts"], status_code=204)
@carries_out(fleet.acknowledge_alert)
async def withdraw_acknowledgement(
    alert_id: AlertId, parts: AllParts, principal: ThePrincipal, condition: ChangeCondition
) -> Response:
    """Withdraw an acknowledgement. Succeeds even if there is none."""
    return await removed(fleet.acknowledge_alert(parts, principal, alert_id, None, condition))
