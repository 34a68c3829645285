"""`/mcp`: the door of agents. Requests pass the same checks as all others; what they ask for is checked again."""

from fastapi import APIRouter, Request
from mcp_types import PARSE_ERROR
from starlette.responses import Response
from starlette.types import Message, Receive, Scope, Send

from dock_gateway.agents.server import AgentServer
from dock_gateway.core.errors import MalformedRequest
from dock_gateway.core.grant import Role
from dock_gateway.core.json_text import decode_json
from dock_gateway.http.operation import Scope as Subject
from dock_gateway.http.operation import operation
from dock_gateway.http.parts import Part
from dock_gateway.http.requests import NO_QUERY, json_response, read_body

router = APIRouter(dependencies=[NO_QUERY])


class AgentResponse(Response):
    """The answer of the MCP server, to a request whose body has been read."""

    def __init__(self, server: AgentServer, body: bytes) -> None:
        super().__init__()
        self._server = server
        self._read = body

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Send the answer."""
        unread: list[Message] = [{"type": "http.request", "body": self._read, "more_body": False}]

        async def receive_again() -> Message:
            return unread.pop() if unread else await receive()

        await self._server.answer(scope, receive_again, send)


@router.post("/mcp", include_in_schema=False)
@operation(Role.VIEWER, Subject.LISTED)
async def mcp(request: Request, server: Part[AgentServer]) -> Response:
    """Answer a message of an agent. The audit log has the calls of tools."""
    request.scope["audit"].leave_to_commands()
    body = await read_body(request)
    try:
        decode_json(body, "the message")  # the protocol's own reader accepts NaN and Infinity
    except MalformedRequest as error:
        refused = {"jsonrpc": "2.0", "id": None, "error": {"code": PARSE_ERROR, "message": error.detail}}
        return json_response(refused, error.status)
    return AgentResponse(server, body)
