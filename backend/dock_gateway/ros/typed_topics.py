"""Topics that the gateway uses with one type each, with endpoints only while that type fits what others have there.

A topic with endpoints of two types is a mistake on the graph: `ros2 topic echo` refuses it, and the two never meet.
What others call `battery_status` may be something else, so nothing is made there before a type fits.

Topics are joined and left on the ROS thread; `update` is called on the loop.
"""

import logging
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from rclpy.exceptions import InvalidTopicNameException
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription

from dock_gateway.ros.bridge import Bridge
from dock_gateway.ros.graph import find_gateways, read_topic
from dock_gateway.ros.listener import Handler
from dock_gateway.ros.messages.types import type_name
from robot_io.rclpy_private import RCLError

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class GatewayEndpoints:
    """The gateway's endpoints on a topic.

    Attributes:
        handlers: Get each message, each by a subscription of its own of this quality.
        publish: The quality of a publisher; None if nothing is published.
        on_open: Called on the ROS thread when the endpoints have been made.
        options: Further options of the endpoints, as rclpy names them.
    """

    handlers: tuple[tuple[Handler, QoSProfile], ...]
    publish: QoSProfile | None = None
    on_open: Callable[[], None] = lambda: None
    options: Mapping[str, Any] = field(default_factory=dict)


class TypedTopic:
    """A topic and our endpoints on it.

    Args:
        topics: All such topics.
        name: Absolute name.
        kind: The message class.
        stop_topic: The topic by whose endpoints gateways are known.
        endpoints: Our endpoints.

    Attributes:
        publisher: Our publisher, while the type fits.
        open: Whether we have our endpoints.
    """

    def __init__(
        self,
        topics: "TypedTopics",
        name: str,
        kind: type,
        stop_topic: str,
        endpoints: GatewayEndpoints,
    ) -> None:
        self.name = name
        self.type = type_name(kind)
        self.open = False
        self.publisher: Publisher | None = None
        self._kind = kind
        self._endpoints = endpoints
        self._subscriptions: list[Subscription] = []
        self._topics = topics
        self._stop_topic = stop_topic
        self._mixed = self._failed = False

    def is_settled(self, types: Sequence[str]) -> bool:
        """Return whether nothing has to be done if these are the topic's types on the graph."""
        return self.open and not self._mixed and set(types) <= {self.type}

    def follow(self, types: Sequence[str] | None) -> None:
        """Make our endpoints if their type fits, destroy them if it does not.

        Args:
            types: The topic's types on the graph; None if they are not known.
        """
        self._mixed = False
        fits = self._fits() if types is None or set(types) - {self.type} else True
        if self.open and not fits:
            log.warning("%s is left, as it is not of type %s", self.name, self.type)
            self.open = False
            self._destroy()
        elif fits and not self.open:
            try:
                self._make()
            # Another part of this process uses the topic with another type, or the robot's namespace is so long that
            # the topic's name would be longer than ROS allows.
            except (RCLError, InvalidTopicNameException) as error:
                if not self._failed:
                    log.warning("%s cannot be used yet: %s", self.name, error)
                self._failed = True
            else:
                self.open, self._failed = True, False

    def _fits(self) -> bool:
        """Return whether our type fits: whether others have it there, too, or there are none."""
        node = self._topics.bridge.node
        topic = read_topic(node, self.name)
        types = topic.types_but_of(frozenset({node.get_fully_qualified_name()}))
        self._mixed = bool(types - {self.type})
        return not self._mixed or self.type in topic.types_but_of(find_gateways(node, self._stop_topic))

    def _make(self) -> None:
        """Make our endpoints: all, or none."""
        node, endpoints = self._topics.bridge.node, self._endpoints
        try:
            if endpoints.publish is not None:
                self.publisher = self._make_publisher(endpoints.publish)
            for handler, quality in endpoints.handlers:
                subscription = node.subscribe(self._kind, self.name, handler, quality, **endpoints.options)
                self._subscriptions.append(subscription)
            endpoints.on_open()
        except Exception:
            self._destroy()
            raise

    def _make_publisher(self, quality: QoSProfile) -> Publisher:
        return self._topics.bridge.node.create_publisher(self._kind, self.name, quality, **self._endpoints.options)

    def _destroy(self) -> None:
        node = self._topics.bridge.node
        while self._subscriptions:
            node.destroy_subscription(self._subscriptions.pop())
        publisher, self.publisher = self.publisher, None
        if publisher is not None:
            node.destroy_publisher(publisher)

    def replace_publisher(self) -> None:
        """Replace the publisher, so that late subscribers no longer get its last message; on the ROS thread."""
        if self.publisher is not None and self._endpoints.publish is not None:
            # Create the new publisher first: the loop may publish at any time.
            old, self.publisher = self.publisher, self._make_publisher(self._endpoints.publish)
            self._topics.bridge.node.destroy_publisher(old)

    def close(self) -> None:
        """Leave the topic for good."""
        self._topics.leave(self)
        if self.open:
            self.open = False
            self._destroy()


class TypedTopics:
    """The topics that are joined.

    Args:
        bridge: The bridge to the ROS thread.
    """

    def __init__(self, bridge: Bridge) -> None:
        self.bridge = bridge
        self._topics: dict[TypedTopic, None] = {}  # in their order
        self._types: Mapping[str, Sequence[str]] | None = None  # at the last scan

    def join(self, name: str, kind: type, stop_topic: str, endpoints: GatewayEndpoints) -> TypedTopic:
        """Join a topic as soon as its type fits; parameters as those of `TypedTopic`."""
        topic = TypedTopic(self, name, kind, stop_topic, endpoints)
        topic.follow(None if self._types is None else self._types.get(name, ()))
        self._topics[topic] = None
        return topic

    def subscribe(
        self, name: str, kind: type, stop_topic: str, handler: Handler, quality: QoSProfile, **options: Any
    ) -> TypedTopic:
        """Join a topic with one subscription; `handler` gets each message."""
        return self.join(name, kind, stop_topic, GatewayEndpoints(((handler, quality),), options=options))

    def leave(self, topic: TypedTopic) -> None:
        """Forget a topic."""
        self._topics.pop(topic, None)

    async def update(self, types: Mapping[str, Sequence[str]]) -> None:
        """Follow the graph.

        Args:
            types: The types of all topics, by name, as a scan found them.

        Raises:
            Unavailable: The ROS thread is down.
        """
        self._types = types
        for topic in list(self._topics):
            seen = types.get(topic.name, ())
            if not topic.is_settled(seen):
                await self.bridge.call(partial(self._follow, topic, seen))

    def _follow(self, topic: TypedTopic, types: Sequence[str]) -> None:
        if topic in self._topics:
            topic.follow(types)
