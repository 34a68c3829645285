"""The ROS graph for API requests: scanned only on demand, once for all simultaneous requests."""

import asyncio
import hashlib
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

from dock_gateway.core.errors import NotFound
from dock_gateway.core.goal import encode
from dock_gateway.core.grant import UNLIMITED, Grant
from dock_gateway.core.graph import GraphScan, Topic, graph_document, narrow_graph
from dock_gateway.core.tasks import cancel
from dock_gateway.ros.bridge import Bridge
from dock_gateway.ros.graph import Survey, read_topic, read_topics

# Minimum seconds between the starts of two scans of the whole graph.
INTERVAL = 1.0


@dataclass(frozen=True)
class View:
    """The encoded graph. The same graph has the same tag."""

    body: bytes
    tag: str
    seen: GraphScan = field(repr=False, compare=False)


class GraphCache:
    """Scans the graph on demand.

    Args:
        bridge: Runs calls on the ROS thread.
        clock: Returns seconds that never go back.
    """

    def __init__(self, bridge: Bridge, clock: Callable[[], float] = time.monotonic) -> None:
        self._bridge = bridge
        self._clock = clock
        self._scanning: asyncio.Task[View] | None = None
        self._last: View | None = None
        self._began = 0.0

    async def graph(self, grant: Grant = UNLIMITED) -> View:
        """Return the graph, at most one second old: all of it, or what a limited grant includes.

        It is the same object for as long as the graph is the same, so that who follows it sees at once that nothing has
        changed.

        Raises:
            Unavailable: `ros_unavailable`, when the ROS thread is down.
        """
        now = self._clock()
        if self._scanning is None or (self._scanning.done() and now - self._began >= INTERVAL):
            self._scanning, self._began = asyncio.create_task(self._scan()), now
        view = await asyncio.shield(self._scanning)  # shared with other requests
        return await asyncio.to_thread(_view, narrow_graph(view.seen, grant)) if grant.limited else view

    async def topic(self, name: str) -> Topic:
        """Return the current state of one topic.

        Raises:
            NotFound: It is not on the graph.
            Unavailable: `ros_unavailable`, when the ROS thread is down.
        """
        topic = await self._bridge.call(lambda: read_topic(self._bridge.node, name))
        if not topic.types:
            raise NotFound(f"there is no topic {name[:200]} on the ROS graph", code="topic_not_found")
        return topic

    async def topics_of(self, types: Iterable[str], namespace: str) -> list[Topic]:
        """Return the current state of the topics of some types in a namespace.

        Raises:
            Unavailable: `ros_unavailable`, when the ROS thread is down.
        """
        return await self._bridge.call(lambda: read_topics(self._bridge.node, frozenset(types), namespace))

    async def _scan(self) -> View:
        survey = await self._bridge.call(lambda: Survey(self._bridge.node))
        while not await self._bridge.call(survey.proceed):
            pass
        self._last = await asyncio.to_thread(_view_after, self._last, survey.seen)
        return self._last

    async def close(self) -> None:
        """Cancel the scan."""
        if self._scanning is not None:
            await cancel(self._scanning)


def _view_after(last: View | None, seen: GraphScan) -> View:
    return last if last is not None and last.seen == seen else _view(seen)


def _view(seen: GraphScan) -> View:
    body = encode(graph_document(seen))
    return View(body, f'"{hashlib.sha256(body).hexdigest()[:32]}"', seen)
