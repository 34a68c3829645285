"""`/rosbridge`: the WebSocket for clients of rosbridge."""

from fastapi import APIRouter, Depends, WebSocket

from dock_gateway.core.grant import Role
from dock_gateway.extensions.rosbridge.session import RosbridgeSession
from dock_gateway.http.operation import Scope, operation
from dock_gateway.http.parts import AllParts
from dock_gateway.http.principal import TICKET, principal_of
from dock_gateway.http.unexpected import known_query
from dock_gateway.streams.queries import read_flag

router = APIRouter()

CANCEL = "cancel_on_disconnect"


@router.websocket("/rosbridge", dependencies=[Depends(known_query(TICKET, CANCEL))])
@operation(Role.VIEWER, Scope.LISTED)
async def rosbridge(websocket: WebSocket, parts: AllParts) -> None:
    """Speak rosbridge v2: receive operations, send messages of topics, feedback and results.

    `?cancel_on_disconnect=true` cancels the goals of the connection when it ends.
    """
    principal = principal_of(websocket)
    cancel = read_flag(websocket.query_params, CANCEL, default=False)
    await RosbridgeSession(websocket, parts, principal, cancel_on_disconnect=cancel).serve()
