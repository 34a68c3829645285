"""The topics that are read: one subscription of each, for those who read its messages as bytes or view them decoded."""

import asyncio
import logging
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from dock_gateway.core.errors import Conflict, FieldError, InvalidField, NotFound
from dock_gateway.core.fanout import Subscriber
from dock_gateway.core.graph import ACTION_PART, Topic
from dock_gateway.core.work import Work
from dock_gateway.graph.cache import GraphCache
from dock_gateway.graph.echo import Viewer
from dock_gateway.graph.relay import TICK, Outlet, Relay
from dock_gateway.ros.bridge import Bridge
from dock_gateway.ros.graph import TOPIC_NAME
from dock_gateway.setting_types import LONGEST_NAME

log = logging.getLogger(__name__)


class Relays:
    """All topics that are read.

    Args:
        bridge: Runs calls on the ROS thread.
        graph: Knows the endpoints of a topic.
        work: Decodes messages for viewers.
        tick: See `TICK`.
    """

    def __init__(self, bridge: Bridge, graph: GraphCache, work: Work, tick: float = TICK) -> None:
        self._work = work
        self._tick = tick
        self._bridge = bridge
        self._graph = graph
        self._relays: dict[str, Relay] = {}
        self._changing = asyncio.Lock()

    async def join(self, topic: str, type_name: str | None, outlet: Outlet) -> None:
        """Pass a topic on to a reader until it leaves.

        Args:
            topic: Absolute name.
            type_name: Its type, as the reader knows it. Needed if no node has the topic yet.
            outlet: Receives the messages.

        Raises:
            Conflict: The topic has another type (`type_conflict`), or the gateway itself uses it with another type
                (`topic_in_use`).
            InvalidField: The name is invalid, or no node has the topic and the reader does not know its type.
            NotFound: Its messages cannot be read here (`interface_not_found`).
            Unavailable: `ros_unavailable`, when the ROS thread is down.
        """
        if not TOPIC_NAME.fullmatch(topic) or len(topic) > LONGEST_NAME:
            raise InvalidField([FieldError("topic", "a name on the ROS graph", f"got {topic[:60]!r}", "query")])
        async with self._changing:
            relay = self._relays.get(topic) or await self._open(await self._find(topic, type_name), type_name)
            if type_name not in (None, relay.kind):
                await self._close_unused(topic)
                raise Conflict(f"the topic {topic} has the type {relay.kind}", code="type_conflict")
            if (hint := relay.hint) is not None:
                await self._close_unused(topic)
                raise NotFound(f"{topic}: {hint}", code="interface_not_found")
            relay.join(outlet)
        try:
            await relay.add(outlet)  # may take long: other topics do not wait for it
        except BaseException:
            await self.leave(topic, outlet)
            raise

    async def leave(self, topic: str, outlet: Outlet) -> None:
        """Pass a topic on to a reader no more. Idempotent."""
        async with self._changing:
            if (relay := self._relays.get(topic)) is not None:
                relay.discard(outlet)
                await self._close_unused(topic)

    @asynccontextmanager
    async def watch(self, topic: str, subscriber: Subscriber, max_rate: float) -> AsyncIterator[None]:
        """Show a topic to a subscriber, at most `max_rate` messages per second, until the block ends.

        Raises:
            Conflict: `topic_in_use`: the gateway itself uses the topic with another type.
            NotFound: There is no such topic.
            Unavailable: `ros_unavailable`, when the ROS thread is down.
        """
        viewer = Viewer(subscriber, 1 / max_rate)
        async with self._changing:
            relay = self._relays.get(topic)
            if relay is None or not relay.viewed:
                found = await self._graph.topic(topic)
                relay = relay or await self._open(found, None)
            relay.view(viewer)
        try:
            yield
        finally:
            relay.hide(viewer)
            async with self._changing:
                if self._relays.get(topic) is relay:
                    await self._close_unused(topic)

    async def _find(self, topic: str, type_name: str | None) -> Topic:
        try:
            return await self._graph.topic(topic)
        except NotFound:
            if ACTION_PART in topic:
                expected, unknown = "an action that has a server", "no server gives the type of the topic yet"
                raise InvalidField([FieldError("topic", expected, unknown, "query")]) from None
            if type_name is None:
                unknown = "no node has this topic yet, so its type has to be given"
                raise InvalidField([FieldError("type", "the type of the topic", unknown, "query")]) from None
            return Topic(topic, [], [])

    async def _open(self, found: Topic, type_name: str | None) -> Relay:
        relay = Relay(self._bridge, self._graph, found, self._work, self._tick)
        try:
            await relay.open(type_name)
        except BaseException:
            await relay.close()
            raise
        self._relays[found.name] = relay
        log.debug("subscribed to %s", found.name)
        return relay

    async def _close_unused(self, topic: str) -> None:
        if not (relay := self._relays[topic]).used:
            del self._relays[topic]
            await relay.close()
            log.debug("unsubscribed from %s", topic)

    async def close(self) -> None:
        """End every subscription."""
        while self._relays:
            await self._relays.popitem()[1].close()
