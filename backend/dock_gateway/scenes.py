"""Who looks at which robot's scene: its topics are heard while somebody does, and a moment longer."""

import asyncio
import logging
from collections.abc import Awaitable, Callable

from dock_gateway.errors import GatewayError
from dock_gateway.hub import Hub
from dock_gateway.ros.bridge import Bridge
from dock_gateway.ros.scene import ScenePort
from dock_gateway.settings import Settings
from dock_gateway.tasks import cancel

log = logging.getLogger(__name__)

TOPIC = "scene"
# A page that is loaded anew is back within so many seconds.
LINGER = 3.0


class Scenes:
    """Opens and closes the scenes of robots as subscribers come and go.

    Args:
        settings: Names.
        bridge: Where the ROS thread is.
        hub: Where events go, and who wants them.
    """

    def __init__(self, settings: Settings, bridge: Bridge, hub: Hub) -> None:
        self._settings = settings
        self._bridge = bridge
        self._hub = hub
        self._ports: dict[str, ScenePort] = {}
        self._changed = asyncio.Event()
        self._task = asyncio.create_task(self._run())
        hub.on_wish(TOPIC, self._changed.set)

    async def _run(self) -> None:
        while True:
            unwatched = self._ports.keys() - self._hub.wished(TOPIC)
            try:
                async with asyncio.timeout(LINGER if unwatched else None):
                    await self._changed.wait()
            except TimeoutError:
                await self._change(self._close, self._ports.keys() - self._hub.wished(TOPIC))
            self._changed.clear()
            await self._change(self._open, self._hub.wished(TOPIC) - self._ports.keys())

    @staticmethod
    async def _change(change: Callable[[str], Awaitable[None]], robots: set[str]) -> None:
        for robot in robots:
            try:
                await change(robot)
            except GatewayError as error:
                log.warning("the scene of %s cannot be shown: %s", robot, error.detail)
            except Exception:
                log.exception("while the scene of %s was opened or closed", robot)

    async def _open(self, robot: str) -> None:
        def make() -> ScenePort:
            return ScenePort(self._bridge, robot, lambda name: self._settings.resolve(name, robot), self._hub.publish)

        self._ports[robot] = await self._bridge.call(make, undo=ScenePort.close)
        log.info("somebody looks at %s", robot)

    async def _close(self, robot: str) -> None:
        self._bridge.to_ros(self._ports.pop(robot).close)
        log.info("nobody looks at %s any more", robot)

    async def close(self) -> None:
        """Look no more."""
        await cancel(self._task)
