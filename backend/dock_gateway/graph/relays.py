"""The relayed topics: one subscription of each topic that is read as bytes."""

import asyncio
import logging

from dock_gateway.core.errors import Conflict, FieldError, InvalidField, NotFound
from dock_gateway.core.graph import ACTION_PART, Topic
from dock_gateway.graph.cache import GraphCache
from dock_gateway.graph.relay import Outlet, Relay
from dock_gateway.ros.bridge import Bridge
from dock_gateway.ros.graph import TOPIC_NAME
from dock_gateway.setting_types import LONGEST_NAME

log = logging.getLogger(__name__)


class Relays:
    """All relayed topics.

    Args:
        bridge: Runs calls on the ROS thread.
        graph: Knows the endpoints of a topic.
    """

    def __init__(self, bridge: Bridge, graph: GraphCache) -> None:
        self._bridge = bridge
        self._graph = graph
        self._relays: dict[str, Relay] = {}
        self._changing = asyncio.Lock()

    async def join(self, topic: str, type_name: str | None, outlet: Outlet) -> None:
        """Pass a topic on to a reader until it leaves.

        Args:
            topic: Absolute name.
            type_name: Its type, as the reader knows it. Needed if nobody has the topic yet.
            outlet: Receives the messages.

        Raises:
            Conflict: The topic has another type (`type_conflict`).
            InvalidField: The name is none, or nobody has the topic, and the reader does not know its type.
            NotFound: Its messages cannot be read here (`interface_not_found`).
            Unavailable: `ros_unavailable`, when the ROS thread is down.
        """
        if not TOPIC_NAME.fullmatch(topic) or len(topic) > LONGEST_NAME:
            raise InvalidField([FieldError("topic", "a name on the ROS graph", f"got {topic[:60]!r}")])
        async with self._changing:
            relay = self._relays.get(topic) or await self._open(topic, type_name)
            if type_name not in (None, relay.kind):
                await self._close_unused(topic)
                raise Conflict(f"the topic {topic} has the type {relay.kind}", code="type_conflict")
            relay.joining.add(outlet)  # so that it stays open
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

    async def _open(self, topic: str, type_name: str | None) -> Relay:
        try:
            found = await self._graph.topic(topic)
        except NotFound:
            if ACTION_PART in topic:
                expected, unknown = "an action that has a server", "no server tells the type of the topic yet"
                raise InvalidField([FieldError("topic", expected, unknown)]) from None
            if type_name is None:
                unknown = "no node has this topic yet, so its type has to be given"
                raise InvalidField([FieldError("type", "the type of the topic", unknown)]) from None
            found = Topic(topic, [], [])
        relay = Relay(self._bridge, self._graph, found)
        try:
            await relay.open(type_name)
        except BaseException:
            await relay.close()
            raise
        self._relays[topic] = relay
        log.debug("subscribed to %s", topic)
        return relay

    async def _close_unused(self, topic: str) -> None:
        relay = self._relays[topic]
        if not relay.outlets and not relay.joining:
            del self._relays[topic]
            await relay.close()
            log.debug("unsubscribed from %s", topic)

    async def close(self) -> None:
        """End every subscription."""
        for relay in self._relays.values():
            await relay.close()
