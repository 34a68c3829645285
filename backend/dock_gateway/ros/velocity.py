"""The velocity topics of robots, `cmd_vel`: zero out, what is commanded in.

A base subscribes to geometry_msgs/Twist or geometry_msgs/TwistStamped; one is deaf to the other. A DDS participant has
one type for each topic, so this one follows the bases, and a branch publishes the other type if there are both.

`VelocityTopics.update` and `VelocityPort.publish_zero` are called on the loop, all else on the ROS thread.
"""

import asyncio
import logging
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import partial
from typing import Any

from geometry_msgs.msg import Twist, TwistStamped
from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.publisher import Publisher
from rclpy.qos_overriding_options import QoSOverridingOptions
from rclpy.subscription import Subscription

from dock_gateway.core.graph import Topic
from dock_gateway.ros.bridge import Bridge, guard
from dock_gateway.ros.graph import read_topic
from dock_gateway.ros.messages.codec import codec
from dock_gateway.ros.qos import LISTEN, TALK
from dock_gateway.ros.robot_ports import OnMessage

log = logging.getLogger(__name__)

TYPES: dict[str, type] = {"geometry_msgs/msg/Twist": Twist, "geometry_msgs/msg/TwistStamped": TwistStamped}
PLAIN, STAMPED = TYPES
# Seconds in which a listener's thread lets go of a subscription, which keeps the participant from another type.
SETTLE = 0.05


class VelocityTopic:
    """One velocity topic.

    Attributes:
        types: The types that are published, that of the listeners first.
        fault: Why zero velocity reaches no base, if that is known.
        listeners: What listens.
    """

    def __init__(self, bridge: Bridge, name: str) -> None:
        self.types: tuple[str, ...] = (PLAIN,)
        self.fault: str | None = None
        self.listeners: list[VelocityListener] = []
        self._bridge = bridge
        self._name = name
        self._publishes = False
        # By type, with the bridge or branch that has it. Replaced, never changed: the loop publishes.
        self._publishers: dict[str, tuple[Bridge, Publisher]] = {}

    @property
    def used(self) -> bool:
        """Whether it has a publisher or a listener."""
        return self._publishes or bool(self.listeners)

    @property
    def complete(self) -> bool:
        """Whether all is published and listened to that should be."""
        published = not self._publishes or set(self.types) == self._publishers.keys()
        return published and all(listener.kind == self.types[0] for listener in self.listeners)

    def look(self) -> None:
        """See which types bases subscribe to, and leave the others. `arrange` joins new ones."""
        topic = read_topic(self._bridge.node, self._name)
        types, fault = choose_types(topic, self.types, self._bridge.node.get_fully_qualified_name())
        if fault != self.fault and fault is not None:
            log.warning("%s", fault)
        self.fault = fault
        if types == self.types:
            return
        log.info("%s is %s", self._name, " and ".join(types))
        if types[0] != self.types[0]:
            for listener in self.listeners:
                listener.leave()
        self.types = types
        self._drop(lambda name, bridge: name not in types or (name == types[0] and bridge is not self._bridge))

    def arrange(self) -> tuple[str, ...]:
        """Publish and listen to the first type; return the types that only a branch can publish."""
        if self._publishes and self.types[0] not in self._publishers:
            with suppress(_rclpy.RCLError):  # another part of this process listens to the former type
                self.add(self._bridge, self.types[0])
        for listener in self.listeners:
            if listener.kind is None:
                with suppress(_rclpy.RCLError):  # the same; it is tried again
                    listener.subscribe(self.types[0])
        return tuple(name for name in self.types if self._publishes and name not in self._publishers)

    def publish(self) -> None:
        """Publish zero velocity from now on."""
        self._publishes = True
        self.look()
        self.arrange()

    def add(self, bridge: Bridge, name: str) -> None:
        """Publish a type, too, on a bridge or a branch."""
        overrides = QoSOverridingOptions.with_default_policies()
        publisher = bridge.node.create_publisher(TYPES[name], self._name, TALK, qos_overriding_options=overrides)
        self._publishers = {**self._publishers, name: (bridge, publisher)}

    def withdraw(self) -> None:
        """Remove the publishers."""
        self._publishes = False
        self._drop(lambda *_: True)

    def _drop(self, unwanted: Callable[[str, Bridge], bool]) -> None:
        """Remove the publishers of unwanted types."""
        before = self._publishers
        self._publishers = {name: both for name, both in before.items() if not unwanted(name, both[0])}
        for name, (bridge, publisher) in before.items():
            if name in self._publishers:
                continue
            if bridge is self._bridge:
                bridge.node.destroy_publisher(publisher)
            else:
                bridge.to_ros(partial(bridge.node.destroy_publisher, publisher))

    def publish_zero(self) -> None:
        """Command zero velocity in all types.

        Raises:
            RuntimeError: No base takes these types, or the publisher is being replaced.
            Exception: ROS does not take the message.
        """
        publishers = self._publishers
        for name, (_, publisher) in publishers.items():
            publisher.publish(self._zero(name))
        if not publishers or self.fault is not None:
            raise RuntimeError(self.fault or f"{self._name} is changing its type")

    def _zero(self, name: str) -> Any:
        message = TYPES[name]()
        if name == STAMPED:
            message.header.stamp = self._bridge.node.get_clock().now().to_msg()
        return message


class VelocityListener:
    """Reports the velocity commanded to a robot, in m/s and rad/s, as a geometry_msgs/Twist.

    Args:
        bridge: The bridge to the ROS thread.
        topics: Knows the topic.
        name: Absolute name of the topic.
        on_velocity: Called on the loop with a message and its source timestamp in ns.

    Attributes:
        kind: The type that it listens to; None while it listens to none.
    """

    def __init__(self, bridge: Bridge, topics: "VelocityTopics", name: str, on_velocity: OnMessage) -> None:
        self._bridge = bridge
        self._topics = topics
        self._name = name
        self.kind: str | None = None
        self._subscription: Subscription | None = None
        twist_codec = codec(Twist)
        inbox = bridge.inbox()

        def hear(message: Twist | TwistStamped, info: dict[str, Any]) -> None:
            velocity = twist_codec.encode(message.twist if isinstance(message, TwistStamped) else message)
            inbox.offer(len(velocity), on_velocity, velocity, info["source_timestamp"])

        self._hear = guard(hear)
        topic = topics.at(name)
        topic.listeners.append(self)
        topic.arrange()

    def subscribe(self, name: str) -> None:
        """Listen to messages of a type."""
        overrides = QoSOverridingOptions.with_default_policies()
        self._subscription = self._bridge.node.create_subscription(
            TYPES[name], self._name, self._hear, LISTEN, qos_overriding_options=overrides
        )
        self.kind = name

    def leave(self) -> None:
        """Stop listening."""
        if self._subscription is not None:
            self._bridge.node.destroy_subscription(self._subscription)
            self._subscription = self.kind = None

    def close(self) -> None:
        """Leave the topic."""
        self.leave()
        self._topics.at(self._name).listeners.remove(self)
        self._topics.forget(self._name)


class VelocityPort:
    """Publishes zero velocity, to stop a robot."""

    def __init__(self, topics: "VelocityTopics", name: str) -> None:
        self._topics = topics
        self._name = name
        self._topic = topics.at(name)
        self._topic.publish()

    def close(self) -> None:
        """Leave the topic."""
        self._topic.withdraw()
        self._topics.forget(self._name)

    def publish_zero(self) -> None:
        """Command zero velocity, immediately.

        Raises:
            RuntimeError: The base subscribes to another type.
            Exception: ROS does not take the message.
        """
        self._topic.publish_zero()


class VelocityTopics:
    """The velocity topics of all robots.

    Args:
        bridge: The bridge to the ROS thread.
    """

    def __init__(self, bridge: Bridge) -> None:
        self._bridge = bridge
        self._topics: dict[str, VelocityTopic] = {}
        self._branch: Bridge | None = None

    def at(self, name: str) -> VelocityTopic:
        """Return a topic by its absolute name."""
        return self._topics.setdefault(name, VelocityTopic(self._bridge, name))

    def forget(self, name: str) -> None:
        """Forget a topic that is no longer used."""
        if not self._topics[name].used:
            del self._topics[name]

    def listen(self, name: str, on_velocity: OnMessage) -> VelocityListener:
        """Listen to a topic."""
        return VelocityListener(self._bridge, self, name, on_velocity)

    async def update(self, types: Mapping[str, Sequence[str]]) -> None:
        """Follow the graph.

        Args:
            types: The types of all topics, by name, as a scan found them.

        Raises:
            Unavailable: The ROS thread is down.
        """
        for name, topic in list(self._topics.items()):
            if topic.complete and topic.fault is None and set(types.get(name, ())) <= set(topic.types):
                continue  # whoever is there is reached
            await self._bridge.call(topic.look)
            if not topic.complete:
                await asyncio.sleep(SETTLE)
            for other in await self._bridge.call(topic.arrange):
                if self._branch is None:
                    self._branch = await self._bridge.branch(float("-inf"))
                await self._branch.call(partial(topic.add, self._branch, other))


def choose_types(topic: Topic, before: tuple[str, ...], own: str) -> tuple[tuple[str, ...], str | None]:
    """Choose the types to publish: what bases subscribe to, else what others publish, else as before.

    A node that publishes on the topic is no base, but for example another gateway.

    Args:
        topic: The endpoints of the topic.
        before: The types that are published now.
        own: Name of our node.

    Returns:
        The types, and why they reach no base, if they do not.
    """
    talking = {endpoint.node for endpoint in topic.publishers} | {own}
    bases = {endpoint.type: endpoint.node for endpoint in topic.subscribers if endpoint.node not in talking}
    wanted = bases.keys() & TYPES.keys()
    if not wanted:
        published = {endpoint.type for endpoint in topic.publishers if endpoint.node != own} & TYPES.keys()
        wanted = {before[0]} & published or published or {before[0]}
        wanted = {min(wanted)}
    fault = None
    if bases and not bases.keys() & TYPES.keys():
        kind, node = min(bases.items())
        fault = f"{topic.name} is subscribed to by {node} as {kind}, which is neither {PLAIN} nor {STAMPED}"
    return tuple(sorted(wanted, key=lambda name: (name != before[0], name))), fault
