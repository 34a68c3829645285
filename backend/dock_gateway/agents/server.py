"""The MCP server: tools, and their calls. One request, one answer: there are no sessions.

`mcp` takes 0.5 s and 18 MB, so this module is imported only where agents are let in.
"""

import asyncio
import logging
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from typing import Any

import orjson
from mcp import MCPError
from mcp.server.context import ServerRequestContext
from mcp.server.lowlevel import Server
from mcp.server.streamable_http_manager import StreamableHTTPSessionManager
from mcp_types import (
    INVALID_PARAMS,
    CallToolRequestParams,
    CallToolResult,
    ListToolsResult,
    PaginatedRequestParams,
    TextContent,
    ToolAnnotations,
)
from mcp_types import Tool as ToolDescription
from starlette.requests import Request
from starlette.types import Receive, Scope, Send

from dock_gateway import __version__
from dock_gateway.access.authorization import authorize_command
from dock_gateway.agents.schema import GoalAnswer
from dock_gateway.agents.tools import TOOLS, Tool, follow, goal_document
from dock_gateway.audit.trail import audited_command
from dock_gateway.core.access import Principal
from dock_gateway.core.errors import GatewayError
from dock_gateway.core.goal import encode
from dock_gateway.goals.goals import Goals
from dock_gateway.http.bodies import body_schema
from dock_gateway.http.parts import Parts, parts_of
from dock_gateway.http.principal import principal_of
from dock_gateway.http.problems import INTERNAL
from dock_gateway.http.slow_clients import send_in_time
from dock_gateway.settings import Settings
from dock_gateway.streams.commands import Fields

log = logging.getLogger(__name__)

Context = ServerRequestContext[Any, Request]

INSTRUCTIONS = (
    "dock-gateway drives ROS 2 robots; first of all, it docks them to their chargers. Call list_robots first. Stop "
    "robots with stop_robots whenever in doubt; only a person can release a stop. A goal to a real robot waits until a "
    "person allows it."
)
# Characters of the name of an agent's program.
MAX_CLIENT = 100


class AgentServer:
    """Answers the requests at `/mcp`."""

    def __init__(self) -> None:
        server = Server(
            "dock-gateway",
            version=__version__,
            title="dock-gateway",
            instructions=INSTRUCTIONS,
            on_list_tools=_list_tools,
            on_call_tool=_call_tool,
        )
        self._manager = StreamableHTTPSessionManager(server, stateless=True)

    @asynccontextmanager
    async def running(self) -> AsyncIterator[None]:
        """Answer requests while the block runs."""
        async with self._manager.run():
            yield

    async def answer(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request. A client that does not read is cut off; the goals that it sent go on."""
        timeout = parts_of(Request(scope))[Settings].subscriber_timeout
        await self._manager.handle_request(scope, receive, lambda message: send_in_time(send, message, timeout))


async def _list_tools(_: Context, __: PaginatedRequestParams | None) -> ListToolsResult:
    return ListToolsResult(tools=[_describe(tool) for tool in TOOLS.values()])


def _describe(tool: Tool) -> ToolDescription:
    return ToolDescription(
        name=tool.name,
        title=tool.title,
        description=tool.description,
        input_schema=body_schema(tool.takes),
        output_schema=body_schema(tool.returns),
        annotations=ToolAnnotations(
            title=tool.title,
            read_only_hint=tool.reads,
            destructive_hint=tool.moves,
            idempotent_hint=tool.reads or tool.repeatable,
            open_world_hint=tool.moves,
        ),
    )


async def _call_tool(context: Context, params: CallToolRequestParams) -> CallToolResult:
    tool = TOOLS.get(params.name)
    if tool is None:
        raise MCPError(INVALID_PARAMS, f"there is no tool {params.name[:100]!r}; there are {', '.join(TOOLS)}")
    call = Call(context, tool)
    try:
        return _answer(await call.carry_out(params.arguments))
    except GatewayError as error:
        return _refusal(error)
    except Exception:
        log.exception("a tool failed")
        return _refusal(INTERNAL)


def _answer(document: Fields) -> CallToolResult:
    text = encode(document).decode()
    return CallToolResult(content=[TextContent(text=text)], structured_content=orjson.loads(text))


def _refusal(error: GatewayError) -> CallToolResult:
    goal = f" The goal is {error.extra['goal_id']}." if "goal_id" in error.extra else ""
    text = f"{error.detail.rstrip('.')} ({error.code}).{goal}"
    return CallToolResult(content=[TextContent(text=text)], is_error=True)


class Call:
    """A call of a tool.

    Args:
        context: The request.
        tool: The tool.
    """

    def __init__(self, context: Context, tool: Tool) -> None:
        request = context.request
        assert request is not None
        self._context = context
        self._tool = tool
        self._parts: Parts = parts_of(request)
        self._client = _client_of(context, request)
        self._principal: Principal = principal_of(request).as_agent(self._client)
        self._scope = {**request.scope, "principal": self._principal}

    async def carry_out(self, arguments: object) -> Fields:
        """Carry out the call; return its answer.

        Raises:
            GatewayError: It was refused or failed.
        """
        tool, parts = self._tool, self._parts
        fields = tool.read(arguments)
        wait = fields.pop("wait_seconds", 0.0)  # of `cancel_goal` it is none
        fields = await tool.prepare(parts, self._principal, fields)
        answer = await audited_command(
            self._scope, tool.what, tool.operation, fields, lambda: self._command(fields), subject=self._client
        )
        if tool.returns is not GoalAnswer:
            return answer
        return await self._wait(answer["goal"]["goal_id"], wait)

    async def _command(self, fields: Fields) -> Fields:
        await authorize_command(self._parts, self._principal, self._tool.what, self._tool.operation, fields)
        return await self._tool.command(self._parts, self._principal, dict(fields))

    async def _wait(self, goal_id: str, seconds: float) -> Fields:
        """Return a goal; before that, wait for its end."""
        if seconds:
            with suppress(TimeoutError):
                async with asyncio.timeout(seconds):
                    await follow(self._parts, self._principal, goal_id, self._report)
        goal = await self._parts[Goals].get(goal_id, self._principal.grant)
        return {"goal": goal_document(goal)}

    async def _report(self, reports: int, text: str) -> None:
        await self._context.session.report_progress(float(reports), message=text)


def _client_of(context: Context, request: Request) -> str:
    """Return what the agent's program calls itself."""
    params = context.session.client_params
    if params is not None:
        name = f"{params.client_info.name} {params.client_info.version}"
    else:
        name = request.headers.get("user-agent", "a program without a name")
    return " ".join(name.split())[:MAX_CLIENT]
