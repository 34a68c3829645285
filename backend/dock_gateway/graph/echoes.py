"""The watched topics. The gateway does not subscribe to any others for viewing."""

import asyncio
import logging
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from dock_gateway.core.fanout import Subscriber
from dock_gateway.core.work import Work
from dock_gateway.graph.cache import GraphCache
from dock_gateway.graph.echo import TICK, Echo, Viewer
from dock_gateway.ros.bridge import Bridge

log = logging.getLogger(__name__)


class EchoRegistry:
    """All watched topics.

    Args:
        bridge: Runs calls on the ROS thread.
        graph: Knows the endpoints of a topic.
        work: Decodes messages.
        tick: Seconds between two rate events and two checks of a topic.
    """

    def __init__(self, bridge: Bridge, graph: GraphCache, work: Work, tick: float = TICK) -> None:
        self._tick = tick
        self._work = work
        self._bridge = bridge
        self._graph = graph
        self._echoes: dict[str, Echo] = {}
        self._changing = asyncio.Lock()

    @asynccontextmanager
    async def watch(self, topic: str, subscriber: Subscriber, max_rate: float) -> AsyncIterator[None]:
        """Show a topic to a subscriber, at most `max_rate` messages per second, until the block ends.

        Raises:
            NotFound: There is no such topic.
            Unavailable: `ros_unavailable`, when the ROS thread is down.
        """
        viewer = Viewer(subscriber, 1 / max_rate)
        async with self._changing:
            echo = self._echoes.get(topic) or await self._open(topic)
            echo.add(viewer)
        try:
            yield
        finally:
            echo.remove(viewer)
            async with self._changing:
                if not echo.viewed and self._echoes.get(topic) is echo:
                    del self._echoes[topic]
                    await echo.close()
                    log.info("unsubscribed from %s", topic)

    async def _open(self, topic: str) -> Echo:
        found = await self._graph.topic(topic)
        echo = Echo(self._bridge, self._graph, found, self._work, self._tick)
        await echo.open()
        self._echoes[topic] = echo
        log.info("subscribed to %s", topic)
        return echo

    async def close(self) -> None:
        """Close every watched topic."""
        for echo in list(self._echoes.values()):
            await echo.close()
