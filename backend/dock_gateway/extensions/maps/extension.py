"""The maps that robots drive on, with what their lasers see and where they are to drive."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from dock_gateway.core.fanout import Fanout
from dock_gateway.core.tasks import closing
from dock_gateway.extension import Extension
from dock_gateway.extensions.maps.error_codes import CODES
from dock_gateway.extensions.maps.routes import router
from dock_gateway.extensions.maps.schema import EVENTS
from dock_gateway.extensions.maps.service import Maps
from dock_gateway.extensions.maps.settings import MapSettings
from dock_gateway.graph.cache import GraphCache
from dock_gateway.graph.relays import Relays
from dock_gateway.http.parts import Parts
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway.settings import Settings


@asynccontextmanager
async def open_maps(parts: Parts) -> AsyncIterator[Maps]:
    """Open what reads maps while a stream or a request asks for them."""
    robots = parts[RobotRegistry]
    maps = Maps(parts[Settings], parts[Relays], parts[GraphCache], parts[Fanout], robots.namespaces)
    async with closing(maps):
        yield maps


extension = Extension(
    "maps",
    open_maps,
    settings=MapSettings,
    routes=lambda _: (router,),
    events=EVENTS,
    errors=CODES,
)
