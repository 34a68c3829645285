"""`/foxglove`: the WebSocket for Foxglove and other viewers that speak its protocol."""

from fastapi import APIRouter, Depends, WebSocket

from dock_gateway.core.errors import MalformedRequest
from dock_gateway.core.grant import Role
from dock_gateway.extensions.foxglove.protocol import SUBPROTOCOLS
from dock_gateway.extensions.foxglove.session import FoxgloveSession
from dock_gateway.http.operation import Scope, operation
from dock_gateway.http.parts import AllParts
from dock_gateway.http.principal import TICKET, principal_of
from dock_gateway.http.unexpected import known_query

router = APIRouter()


@router.websocket("/foxglove", dependencies=[Depends(known_query(TICKET))])
@operation(Role.VIEWER, Scope.LISTED)
async def foxglove(websocket: WebSocket, parts: AllParts) -> None:
    """Speak the protocol of Foxglove: channels, parameters, services, and actions as services."""
    offered = websocket.scope["subprotocols"]
    chosen = next((name for name in offered if name in SUBPROTOCOLS), None)
    if chosen is None:
        expected = f"connect with the subprotocol {' or '.join(SUBPROTOCOLS)}"
        raise MalformedRequest(expected, code="subprotocol_required")
    await FoxgloveSession(websocket, parts, principal_of(websocket)).serve(chosen)
