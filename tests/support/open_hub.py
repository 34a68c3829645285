"""A hub in this process, over a real NATS server."""

from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass
from pathlib import Path

import httpx2
from starlette.types import Receive, Scope, Send

from dock_gateway.access.logins import Logins
from dock_gateway.core.grant import Grant, Role
from dock_gateway.extension import Installed
from dock_gateway.http.parts import Parts
from dock_hub.app import create_hub_app
from dock_hub.assembly import open_hub
from dock_hub.directory import SiteState
from dock_hub.extensions import hub_extensions
from dock_hub.settings import HubSettings
from dock_hub.sites import Sites
from tests.support.edge import serving
from tests.support.waiting import until


@dataclass
class Hub:
    """A hub, its address and an HTTP client for it."""

    parts: Parts
    url: str
    http: httpx2.AsyncClient

    async def token(self, name: str, role: Role, *robots: str) -> tuple[str, dict[str, str]]:
        """The id of a new token, and the header that shows it."""
        token, secret = await self.parts[Logins].create_token(name, Grant(role, robots))
        return token["id"], {"Authorization": f"Bearer {secret}"}

    async def connected(self, name: str) -> None:
        sites = self.parts[Sites]
        await until(lambda: name in sites.names() and not sites.view(name).behind)
        assert sites.state(name) is SiteState.CONNECTED


@asynccontextmanager
async def hub_at(nats: str, folder: Path, installed: Installed | None = None) -> AsyncIterator[Hub]:
    """Open a hub that asks for a login, on a broker; its key and its database are in the folder."""
    settings = HubSettings(
        database_url=f"sqlite:///{folder}/hub.db",
        spool_path=folder / "spool",
        hub_private_key=folder / "hub.key",
        nats=(nats,),
        authentication=True,
    )
    async with AsyncExitStack() as stack:
        parts = await stack.enter_async_context(open_hub(settings, installed or hub_extensions()))
        app = create_hub_app(settings, parts)

        async def with_parts(scope: Scope, receive: Receive, send: Send) -> None:
            scope["state"] = {"parts": parts}
            await app(scope, receive, send)

        edge = await stack.enter_async_context(serving(with_parts))
        http = await stack.enter_async_context(httpx2.AsyncClient(base_url=edge.url, trust_env=False))
        yield Hub(parts, edge.url, http)
