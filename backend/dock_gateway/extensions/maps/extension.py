"""The maps that robots drive on, with what their lasers see and where they are to drive."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from dock_gateway.core.tasks import closing
from dock_gateway.extension import Extension, GatewayCore
from dock_gateway.extensions.maps.routes import router
from dock_gateway.extensions.maps.schema import MapEvent, MapsEvent, PathEvent, ScanEvent
from dock_gateway.extensions.maps.service import Maps
from dock_gateway.extensions.maps.settings import MapSettings


@asynccontextmanager
async def open_maps(core: GatewayCore) -> AsyncIterator[Maps]:
    """Open what reads maps while a stream or a request asks for them."""
    async with closing(Maps(core.settings, core.topics, core.graph, core.events, core.robots.namespaces)) as maps:
        yield maps


extension = Extension(
    "maps",
    open_maps,
    settings=MapSettings,
    routes=lambda _: (router,),
    includes=("map", "maps", "scan", "path"),
    events=(MapEvent, MapsEvent, ScanEvent, PathEvent),
)
