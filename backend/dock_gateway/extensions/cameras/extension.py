"""The cameras of robots."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from dock_gateway.core.fanout import Fanout
from dock_gateway.core.tasks import closing
from dock_gateway.extension import Extension
from dock_gateway.extensions.cameras.cameras import Cameras
from dock_gateway.extensions.cameras.error_codes import CODES
from dock_gateway.extensions.cameras.routes import router
from dock_gateway.extensions.cameras.settings import CameraSettings
from dock_gateway.graph.cache import GraphCache
from dock_gateway.graph.relays import Relays
from dock_gateway.http.parts import Parts
from dock_gateway.http.quotas import Limit
from dock_gateway.robots.registry import RobotRegistry
from dock_gateway.settings import Settings


@asynccontextmanager
async def open_cameras(parts: Parts) -> AsyncIterator[Cameras]:
    """Open what finds cameras, and watches them for viewers."""
    settings = parts[Settings].of(CameraSettings)
    cameras = Cameras(settings, parts[Fanout], parts[RobotRegistry], parts[GraphCache], parts[Relays])
    async with closing(cameras):
        yield cameras


extension = Extension(
    "cameras",
    open_cameras,
    settings=CameraSettings,
    routes=lambda _: (router,),
    limits=lambda _: {"cameras": Limit("cameras being watched", 50, 20, 10)},
    errors=CODES,
)
