"""The cameras of robots."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from dock_gateway.core.tasks import closing
from dock_gateway.extension import Extension, GatewayCore
from dock_gateway.extensions.cameras.cameras import Cameras
from dock_gateway.extensions.cameras.routes import router
from dock_gateway.extensions.cameras.settings import CameraSettings
from dock_gateway.http.quotas import Limit


@asynccontextmanager
async def open_cameras(core: GatewayCore) -> AsyncIterator[Cameras]:
    """Open what finds cameras, and watches them for viewers."""
    settings = core.settings.of(CameraSettings)
    async with closing(Cameras(settings, core.events, core.robots, core.graph, core.topics)) as cameras:
        yield cameras


extension = Extension(
    "cameras",
    open_cameras,
    settings=CameraSettings,
    routes=lambda _: (router,),
    limits=lambda _: {"cameras": Limit("cameras being watched", 50, 20, 10)},
)
