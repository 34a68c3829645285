"""The MCP server: what it says about the tools, and the answers to calls. There are no sessions.

`mcp` takes 0.5 s and 18 MB, so this module is imported only where agents are let in.
"""

import logging
from collections.abc import AsyncIterator, Callable, Iterable
from contextlib import asynccontextmanager
from typing import Any

import orjson
from mcp import MCPError
from mcp.server.lowlevel import Server
from mcp.server.streamable_http_manager import StreamableHTTPSessionManager
from mcp_types import (
    INVALID_PARAMS,
    CallToolRequestParams,
    CallToolResult,
    InputRequiredResult,
    ListToolsResult,
    PaginatedRequestParams,
    TextContent,
    ToolAnnotations,
)
from mcp_types import Tool as ToolDescription
from starlette.requests import Request
from starlette.types import Receive, Send
from starlette.types import Scope as ConnectionScope

from dock_gateway import __version__
from dock_gateway.access.carry_out import Fields
from dock_gateway.access.tool import Tool
from dock_gateway.core.errors import GatewayError
from dock_gateway.core.goal import encode
from dock_gateway.extensions.agents.calls import Call, Context, Questions
from dock_gateway.extensions.agents.tools import TOOLS
from dock_gateway.http.bodies import body_schema
from dock_gateway.http.parts import parts_of
from dock_gateway.http.problems import INTERNAL
from dock_gateway.http.slow_clients import send_in_time
from dock_gateway.settings import Settings

log = logging.getLogger(__name__)

INSTRUCTIONS = (
    "dock-gateway drives ROS 2 robots; first of all, it docks them to their chargers. Call list_robots first. Stop "
    "robots with stop_robots whenever in doubt; only a person can release a stop. A goal to a real robot waits until a "
    "person allows it."
)


class AgentServer:
    """Answers the requests at `/mcp`.

    Args:
        further: Returns the tools of other extensions.
    """

    def __init__(self, further: Callable[[], Iterable[Tool]] = tuple) -> None:
        self._further = further
        self._questions = Questions()
        server = Server(
            "dock-gateway",
            version=__version__,
            title="dock-gateway",
            instructions=INSTRUCTIONS,
            on_list_tools=self._list_tools,
            on_call_tool=self._call_tool,
            get_tool_input_schema=self._schema_of,
        )
        self._manager = StreamableHTTPSessionManager(server, stateless=True)

    @asynccontextmanager
    async def running(self) -> AsyncIterator[None]:
        """Answer requests while the block runs."""
        async with self._manager.run():
            yield

    async def answer(self, scope: ConnectionScope, receive: Receive, send: Send) -> None:
        """Answer a request. A client that does not read is cut off; the goals that it sent go on."""
        timeout = parts_of(Request(scope))[Settings].subscriber_timeout
        await self._manager.handle_request(scope, receive, lambda message: send_in_time(send, message, timeout))

    def _tools(self) -> dict[str, Tool]:
        """Return all tools, by their names. Those of extensions come last."""
        return {tool.name: tool for tool in (*TOOLS.values(), *self._further())}

    def _schema_of(self, name: str) -> dict[str, Any] | None:
        tool = self._tools().get(name)
        return None if tool is None else body_schema(tool.takes)

    async def _list_tools(self, _: Context, __: PaginatedRequestParams | None) -> ListToolsResult:
        return ListToolsResult(tools=[_describe(tool) for tool in self._tools().values()])

    async def _call_tool(self, context: Context, params: CallToolRequestParams) -> CallToolResult | InputRequiredResult:
        tools = self._tools()
        tool = tools.get(params.name)
        if tool is None:
            raise MCPError(INVALID_PARAMS, f"there is no tool {params.name[:100]!r}; there are {', '.join(tools)}")
        try:
            answer = await Call(context, tool, params, self._questions).carry_out()
        except GatewayError as error:
            return _refusal(error)
        except Exception:
            log.exception("a tool failed")
            return _refusal(INTERNAL)
        return answer if isinstance(answer, InputRequiredResult) else _answer(answer)


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


def _answer(document: Fields) -> CallToolResult:
    text = encode(document).decode()
    return CallToolResult(content=[TextContent(text=text)], structured_content=orjson.loads(text))


def _refusal(error: GatewayError) -> CallToolResult:
    goal = f" The goal is {error.extra['goal_id']}." if "goal_id" in error.extra else ""
    text = f"{error.detail.rstrip('.')} ({error.code}).{goal}"
    return CallToolResult(content=[TextContent(text=text)], is_error=True)
