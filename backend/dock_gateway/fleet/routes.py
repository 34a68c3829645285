"""`/robots`: a summary of every robot, and its label. `/alerts`: the active alerts and who acknowledged them."""

from typing import Annotated

from fastapi import APIRouter, Path, Request

from dock_gateway.audit.trail import audited
from dock_gateway.core.errors import not_covered
from dock_gateway.core.grant import Role
from dock_gateway.core.namespace import read_namespace
from dock_gateway.fleet.alerts import AlertBoard
from dock_gateway.fleet.overview import Fleet
from dock_gateway.fleet.schema import AcknowledgementBody, Alert, AlertList, Label, RobotList
from dock_gateway.http.bodies import body_schema, read, read_signed
from dock_gateway.http.openapi import body
from dock_gateway.http.operation import Scope, operation
from dock_gateway.http.parts import Part
from dock_gateway.http.principal import TheGrant
from dock_gateway.http.requests import (
    Answer,
    RobotQuery,
    json_response,
)
from dock_gateway.http.route import ApiRoute
from dock_gateway.robots.labels import Labels
from dock_gateway.storage import RobotLabel

router = APIRouter(route_class=ApiRoute)


@router.get("/robots", tags=["Robots"])
@operation(Role.VIEWER, Scope.LISTED, errors=(404, 421))
async def list_robots(fleet: Part[Fleet], grant: TheGrant, robot: RobotQuery = None) -> Answer[RobotList]:
    """List every robot that was found, or only the one given by `robot`."""
    if robot is not None and not grant.own.covers_robot(name := read_namespace(robot)):
        raise not_covered(f"the robot {name}")
    return json_response({"robots": fleet.documents(robot, grant)})


@router.put("/robots/label", tags=["Robots"], openapi_extra=body(body_schema(Label), required=True))
@operation(Role.SUPERVISOR, Scope.EVERY, errors=(409,))
async def label_robot(request: Request, labels: Part[Labels]) -> Answer[Label]:
    """Replace the display name and the groups of a robot, at every gateway that shares the history.

    `null` without groups removes the label. A label outlives restarts, and may be set before the robot appears.
    """
    label = await read(Label, request)
    audited(request, robot=label.robot)
    await labels.replace(label.robot, RobotLabel(label.display_name, label.groups))
    return json_response(label.model_dump())


AlertId = Annotated[str, Path(description="`id` of the alert")]


@router.get("/alerts", tags=["Alerts"])
@operation(Role.VIEWER, Scope.LISTED)
async def list_alerts(alerts: Part[AlertBoard], grant: TheGrant) -> Answer[AlertList]:
    """List the active alerts: critical ones first, then oldest first."""
    return json_response({"alerts": alerts.documents(grant)})


@router.put(
    "/alerts/{alert_id}/acknowledgement",
    tags=["Alerts"],
    openapi_extra=body(body_schema(AcknowledgementBody), required=True),
)
@operation(Role.OPERATOR, Scope.ALERT)
async def acknowledge(alert_id: AlertId, request: Request, alerts: Part[AlertBoard]) -> Answer[Alert]:
    """Acknowledge an alert. This holds at every gateway that shares the history, until the alert clears."""
    body = await read_signed(AcknowledgementBody, request)
    return json_response(await alerts.acknowledge(alert_id, body.by))


@router.delete("/alerts/{alert_id}/acknowledgement", tags=["Alerts"])
@operation(Role.OPERATOR, Scope.ALERT)
async def withdraw_acknowledgement(alert_id: AlertId, alerts: Part[AlertBoard]) -> Answer[Alert]:
    """Withdraw an acknowledgement. Succeeds even if there is none."""
    return json_response(await alerts.withdraw(alert_id))
