"""The door of agents: `/mcp`. `mcp` takes 0.5 s and 18 MB, so it is imported only where agents are let in."""

from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager

from fastapi import APIRouter

from dock_gateway.extension import Extension, Installed
from dock_gateway.extensions.agents.settings import AgentSettings
from dock_gateway.http.parts import Parts
from dock_gateway.settings import Settings


@asynccontextmanager
async def open_agents(parts: Parts) -> AsyncIterator[object]:
    """Answer agents, if they are let in."""
    if not parts[Settings].of(AgentSettings).mcp:
        yield None
        return
    from dock_gateway.extensions.agents.server import AgentServer  # noqa: PLC0415 - see above

    server = AgentServer(lambda: parts[Installed].tools)
    async with server.running():
        yield server


def agent_routes(settings: Settings) -> Sequence[APIRouter]:
    """Return the routes of agents, if they are let in."""
    if not settings.of(AgentSettings).mcp:
        return ()
    from dock_gateway.extensions.agents.routes import router  # noqa: PLC0415 - see above

    return (router,)


extension = Extension("agents", open_agents, settings=AgentSettings, routes=agent_routes)
