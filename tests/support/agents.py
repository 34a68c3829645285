"""Agents: the official client of the Model Context Protocol, over real HTTP."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

import httpx2
from mcp import Client
from mcp.client.streamable_http import streamable_http_client
from mcp_types import CallToolResult, Implementation

from tests.support.access import bearer
from tests.support.gateway import RunningGateway


@asynccontextmanager
async def agent(gateway: RunningGateway, token: str | None = None, **options: Any) -> AsyncIterator[Client]:
    """An agent, with a token or without one."""
    async with httpx2.AsyncClient(headers={} if token is None else bearer(token), timeout=60) as http:
        transport = streamable_http_client(f"{gateway.url}/mcp", http_client=http)
        info = Implementation(name="test-agent", version="1.0")
        async with Client(transport, client_info=info, **options) as client:
            yield client


def text(result: CallToolResult) -> str:
    return " ".join(item.text for item in result.content if item.type == "text")


def answer(result: CallToolResult) -> dict[str, Any]:
    """What a tool that has not failed returned."""
    assert not result.is_error, text(result)
    assert result.structured_content is not None
    return result.structured_content


def refusal(result: CallToolResult) -> str:
    assert result.is_error, result
    return text(result)
