"""`/mcp`: the door of agents. Requests pass the same checks as all others; what they ask for is checked again."""

import asyncio
from collections.abc import Mapping
from typing import Any

from fastapi import APIRouter, Request
from mcp_types import PARSE_ERROR
from starlette.responses import Response
from starlette.types import Message, Receive, Send
from starlette.types import Scope as ConnectionScope

from dock_gateway.access.carry_out import carry_out
from dock_gateway.core.errors import MalformedRequest
from dock_gateway.core.grant import Role
from dock_gateway.core.json_text import decode_json
from dock_gateway.extensions.agents.calls import STOPPING, client_name
from dock_gateway.extensions.agents.server import AgentServer
from dock_gateway.extensions.agents.tools import STOP_TOOL, TOOLS
from dock_gateway.http.openapi import body
from dock_gateway.http.operation import Scope, operation
from dock_gateway.http.parts import AllParts, Part
from dock_gateway.http.principal import principal_of
from dock_gateway.http.requests import json_response, read_body
from dock_gateway.http.route import ApiRoute
from dock_gateway.http.unexpected import known_query
from dock_gateway.stop.order import says

router = APIRouter(route_class=ApiRoute)

# How a character of a name may be written in JSON.
ESCAPE = b"\\u"


class AgentResponse(Response):
    """The answer of the MCP server, to a request whose body has been read."""

    def __init__(self, server: AgentServer, body: bytes) -> None:
        super().__init__()
        self._server = server
        self._read = body

    async def __call__(self, scope: ConnectionScope, receive: Receive, send: Send) -> None:
        """Send the answer."""
        unread: list[Message] = [{"type": "http.request", "body": self._read, "more_body": False}]

        async def receive_again() -> Message:
            return unread.pop() if unread else await receive()

        await self._server.answer(scope, receive_again, send)


@router.post("/mcp", include_in_schema=False, openapi_extra=body({"type": "object"}, required=True))
@operation(Role.VIEWER, Scope.LISTED, any_query=True)
async def mcp(request: Request, server: Part[AgentServer], parts: AllParts) -> Response:
    """Answer a message of an agent. The audit log has the calls of tools.

    A stop does not depend on what the protocol thinks of the rest of the message: it is carried out before that.
    """
    request.scope["audit"].leave_to_commands()
    message = await read_body(request)
    for asked in _stops_in(message):
        name = client_name(request)
        who, stop = principal_of(request).as_agent(name), TOOLS[STOP_TOOL].command
        scope = {**request.scope, "principal": who}
        stopping = asyncio.create_task(carry_out(parts, who, stop, asked, scope, subject=name))
        request.scope[STOPPING] = stopping
        await asyncio.wait({stopping})
    await known_query()(request)
    try:
        decode_json(message, "the message")  # the protocol's own reader accepts NaN and Infinity
    except MalformedRequest as error:
        refused = {"jsonrpc": "2.0", "id": None, "error": {"code": PARSE_ERROR, "message": error.detail}}
        return json_response(refused, error.status)
    return AgentResponse(server, message)


def _stops_in(message: bytes) -> list[object]:
    """Return what calls of the tool that stops robots say."""
    if STOP_TOOL.encode() not in message and ESCAPE not in message:
        return []
    try:
        decoded = decode_json(message, "the message", constants=True)
    except MalformedRequest as error:
        return [error] if says(message, "name", STOP_TOOL) else []
    calls: list[Any] = [each.get("params") for each in _items(decoded) if each.get("method") == "tools/call"]
    named = [call for call in calls if isinstance(call, Mapping) and call.get("name") == STOP_TOOL]
    said = [{} if (arguments := call.get("arguments")) is None else arguments for call in named]
    return [each if isinstance(each, Mapping) else {"robot": each} for each in said]


def _items(decoded: Any) -> list[Mapping[str, Any]]:
    return [each for each in (decoded if isinstance(decoded, list) else [decoded]) if isinstance(each, Mapping)]
