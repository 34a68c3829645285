"""`/alerts`: what an operator has to know of, and who has seen it."""

from typing import Annotated

from fastapi import APIRouter, Depends, Path, Request
from starlette.responses import Response

from dock_gateway.api.answers import TheGateway, json_response
from dock_gateway.api.openapi import body
from dock_gateway.api.problems import problems
from dock_gateway.api.requests import known_query, name_schema, read_json, read_name, read_object
from dock_gateway.api.schemas import Alert, AlertList

router = APIRouter(tags=["Alerts"], prefix="/alerts", dependencies=[Depends(known_query())])

MAX_NAME = 60
ACKNOWLEDGEMENT_REQUEST = {
    "type": "object",
    "required": ["by"],
    "additionalProperties": False,
    "properties": {"by": name_schema(MAX_NAME) | {"description": "Who has seen the alert"}},
}
AlertId = Annotated[str, Path(description="`id` of the alert")]


@router.get("", response_model=AlertList, responses=problems(422))
async def list_alerts(gateway: TheGateway) -> Response:
    """What is wrong now: critical alerts first, then the oldest first."""
    return json_response({"alerts": gateway.alarm.documents()})


@router.put(
    "/{alert_id}/acknowledgement",
    response_model=Alert,
    responses=problems(400, 404, 408, 413, 415, 422),
    openapi_extra=body(ACKNOWLEDGEMENT_REQUEST, required=True),
)
async def acknowledge(alert_id: AlertId, request: Request, gateway: TheGateway) -> Response:
    """Somebody has seen an alert. That holds at every gateway with the same history, until the alert is over."""
    by = read_name(read_object(await read_json(request), "by").get("by"), MAX_NAME)
    return json_response(await gateway.alarm.acknowledge(alert_id, by))


@router.delete("/{alert_id}/acknowledgement", response_model=Alert, responses=problems(404, 422))
async def withdraw_acknowledgement(alert_id: AlertId, gateway: TheGateway) -> Response:
    """Take an acknowledgement back; also where there is none."""
    return json_response(await gateway.alarm.withdraw(alert_id))
