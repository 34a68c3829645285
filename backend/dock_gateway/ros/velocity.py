"""The velocity topics of robots, `cmd_vel`: publishes zero, receives the commanded velocity.

A base subscribes to geometry_msgs/Twist or geometry_msgs/TwistStamped; one is deaf to the other. A DDS participant has
one type for each topic, so this one follows the bases, and a branch has the other type if there are both.

`VelocityTopics.update`, `VelocityPort.publish_zero` and properties are called on the loop, what a branch adds on its
thread, all else on the ROS thread.
"""

import asyncio
import logging
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import partial
from typing import Any

from geometry_msgs.msg import Twist, TwistStamped
from rclpy.publisher import Publisher
from rclpy.qos_overriding_options import QoSOverridingOptions
from rclpy.serialization import deserialize_message
from rclpy.subscription import Subscription

from dock_gateway.core.velocity_types import choose_types
from dock_gateway.ros.bridge import Bridge
from dock_gateway.ros.endpoints import Endpoints
from dock_gateway.ros.graph import find_gateways, read_topic
from dock_gateway.ros.listener import Handler
from dock_gateway.ros.listening_node import ListeningNode
from dock_gateway.ros.messages.codec import codec
from dock_gateway.ros.robot_ports import OnMessage
from robot_io.qos import LISTEN, TALK
from robot_io.rclpy_private import Buffer, InvalidHandle, RCLError, exists
from robot_io.reception import arrived_at
from robot_io.velocity import CLASSES, is_motion, twist_of, velocity_message
from robot_io.velocity_types import PLAIN

log = logging.getLogger(__name__)

OnVelocity = Callable[[Twist | TwistStamped, dict[str, Any]], None]

# Seconds in which a listener's thread lets go of a subscription, which keeps the participant from another type.
SETTLE = 0.05


class VelocityTopic:
    """One velocity topic.

    Attributes:
        types: The types that are published and listened to: none while others use it with other types only.
        stop_topics: The topics that tell who is a gateway.
        fault: Why zero velocity reaches no base, if that is known.
        listeners: Those who listen through the gateway.
        subscriptions: Theirs, until they are destroyed: later than they are closed, if a thread still uses them.
    """

    def __init__(self, bridge: Bridge, name: str) -> None:
        self.types: tuple[str, ...] = (PLAIN,)
        self.fault: str | None = None
        self.stop_topics: set[str] = set()
        self.listeners: list[VelocityListener] = []
        self.subscriptions: list[Subscription] = []
        self._bridge = bridge
        self._name = name
        self._ports = 0

        def make(node: ListeningNode, kind: type) -> Publisher:
            overrides = QoSOverridingOptions.with_default_policies()
            return node.create_publisher(kind, name, TALK, qos_overriding_options=overrides)

        self._publishers = Endpoints(bridge, make, ListeningNode.destroy_publisher)

    @property
    def used(self) -> bool:
        """Whether it has a publisher or a listener."""
        return bool(self._ports or self.listeners)

    @property
    def missing(self) -> tuple[str, ...]:
        """The types that are not published and listened to yet."""
        used = [
            *([self._publishers.of] if self._ports else []),
            *(each.subscriptions.of for each in self.listeners),
        ]
        return tuple(name for name in self.types if any(name not in endpoints for endpoints in used))

    def update_types(self) -> None:
        """Read which types bases subscribe to, and leave the others. `arrange` joins new ones."""
        node = self._bridge.node
        topic, own = read_topic(node, self._name), node.get_fully_qualified_name()
        gateways = {own}
        if topic.types_but_of({own}) - CLASSES.keys():
            gateways = gateways.union(*(find_gateways(node, name) for name in self.stop_topics))
        types, fault = choose_types(topic, self.types, own, gateways)
        if fault != self.fault and fault is not None:
            log.warning("%s", fault)
        self.fault = fault
        if types == self.types:
            return
        log.info("%s is %s", self._name, " and ".join(types) or "left, as it is of another type")
        self.types = types

        def unwanted(name: str, bridge: Bridge) -> bool:
            return name not in types or (name == types[0] and bridge is not self._bridge)

        for endpoints in (self._publishers, *(listener.subscriptions for listener in self.listeners)):
            endpoints.drop(unwanted)

    def arrange(self) -> tuple[str, ...]:
        """Publish and listen to the first type; return the types that only a branch can have."""
        for name in self.types[:1]:
            with suppress(RCLError):  # another part of this process listens to the former type
                self.add(self._bridge, name)
        return self.missing

    def publish(self) -> None:
        """Publish zero velocity from now on."""
        self._ports += 1
        self.update_types()
        self.arrange()

    def add(self, bridge: Bridge, name: str) -> None:
        """Publish and listen to a type, too, on a bridge or a branch."""
        if self._ports:
            self._publishers.add(bridge, name)
        for listener in tuple(self.listeners):
            listener.subscriptions.add(bridge, name)

    def leave(self, listener: "VelocityListener") -> None:
        """Listen no longer."""
        self.listeners.remove(listener)
        listener.subscriptions.close()
        for each in tuple(self.subscriptions):
            if not exists(each):
                self.subscriptions.remove(each)

    def withdraw(self) -> None:
        """Publish no longer, unless another port does."""
        self._ports -= 1
        if not self._ports:
            self._publishers.drop()

    def close(self) -> None:
        """Take no more publishers."""
        self._publishers.close()

    @property
    def subscribers(self) -> int:
        """The number of subscriptions that its publishers are matched with, without its own listeners."""
        count = 0
        own = [each.msg_type for each in tuple(self.subscriptions) if exists(each)]
        for name, (_, publisher) in self._publishers.of.items():
            with suppress(InvalidHandle, RCLError):  # it was just destroyed
                count += publisher.get_subscription_count() - own.count(CLASSES[name])
        return count

    def publish_zero(self) -> None:
        """Command zero velocity in all types.

        Raises:
            RuntimeError: No base takes these types, or the publisher is being replaced.
            Exception: ROS does not take the message.
        """
        publishers = self._publishers.of
        for name, (_, publisher) in publishers.items():
            publisher.publish(velocity_message(name, Twist(), self._bridge.node))
        if not publishers or self.fault is not None:
            reason = "is changing its type" if self.types else "is of another type"
            raise RuntimeError(self.fault or f"{self._name} {reason}")


class VelocityListener:
    """Hears the velocities commanded to a robot.

    Args:
        bridge: The bridge to the ROS thread.
        topics: Knows the topic.
        name: Absolute name of the topic.
        hear: Called with a message and its info, as in `Buffer`, on the listener's thread, or in `catch_up`.

    Attributes:
        subscriptions: One for each type of the topic.
    """

    def __init__(self, bridge: Bridge, topics: "VelocityTopics", name: str, hear: OnVelocity) -> None:
        self._topics = topics
        self._name = name
        self._topic = topics.at(name)
        self._hear = Handler(hear)
        self._buffer = Buffer()

        def make(node: ListeningNode, kind: type) -> Subscription:
            overrides = QoSOverridingOptions.with_default_policies()
            made = node.subscribe(kind, name, self._hear, LISTEN, qos_overriding_options=overrides)
            self._topic.subscriptions.append(made)
            return made

        self.subscriptions = Endpoints(bridge, make, ListeningNode.destroy_subscription)
        self._topic.listeners.append(self)
        self._topic.arrange()

    @property
    def complete(self) -> bool:
        """Whether it hears all that reaches a base."""
        return self.subscriptions.of.keys() >= set(self._topic.types)

    def catch_up(self) -> None:
        """Hear, on the loop, what has arrived and waits for the listener's thread, which may have had no turn."""
        for _, subscription in self.subscriptions.of.values():
            try:
                with subscription.handle:
                    while self._buffer.take(subscription):
                        self._hear(deserialize_message(self._buffer.read(), subscription.msg_type), self._buffer.info)
            except InvalidHandle:  # it was just destroyed
                continue
            except Exception as error:  # noqa: BLE001 - whatever the bytes of others bring about
                log.warning("a message on %s cannot be read: %s", self._name, error)

    def close(self) -> None:
        """Leave the topic."""
        self._topic.leave(self)
        self._topics.forget(self._name)


class VelocityPort:
    """Publishes zero velocity, to stop a robot.

    Args:
        topics: Knows the topic.
        name: Absolute name of the topic.
        stop_topic: The topic by whose endpoints gateways are known.
    """

    def __init__(self, topics: "VelocityTopics", name: str, stop_topic: str) -> None:
        self._topics = topics
        self._name = name
        self._topic = topics.at(name)
        self._topic.stop_topics.add(stop_topic)
        self._topic.publish()

    def close(self) -> None:
        """Leave the topic."""
        self._topic.withdraw()
        self._topics.forget(self._name)

    @property
    def subscribers(self) -> int:
        """The number of subscriptions that it reaches now."""
        return self._topic.subscribers

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
            self._topics.pop(name).close()

    def listen(self, name: str, on_velocity: OnMessage) -> VelocityListener:
        """Listen to a topic.

        Args:
            name: Absolute name of the topic.
            on_velocity: Called on the loop with a velocity, in m/s and rad/s, as a geometry_msgs/Twist in JSON, and its
                source timestamp in ns.
        """
        twist_codec = codec(Twist)
        inbox = self._bridge.inbox()

        def hear(message: Twist | TwistStamped, info: dict[str, Any]) -> None:
            velocity = twist_codec.encode(twist_of(message))
            inbox.offer(len(velocity), on_velocity, velocity, info["source_timestamp"])

        return VelocityListener(self._bridge, self, name, hear)

    def watch(self, name: str, on_command: Callable[[bool, bytes, float], None]) -> VelocityListener:
        """Watch who drives.

        Args:
            name: Absolute name of the topic.
            on_command: Called for each message, on the listener's thread or in `catch_up`: whether it is a motion, its
                publisher, and when it arrived, on the monotonic clock.
        """

        def hear(message: Twist | TwistStamped, info: dict[str, Any]) -> None:
            on_command(is_motion(message), info["publisher"], arrived_at(info))

        return VelocityListener(self._bridge, self, name, hear)

    async def update(self, types: Mapping[str, Sequence[str]]) -> None:
        """Follow the graph.

        Args:
            types: The types of all topics, by name, as a scan found them.

        Raises:
            Unavailable: The ROS thread is down.
        """
        for name, topic in list(self._topics.items()):
            known = topic.types and topic.fault is None and set(types.get(name, ())) <= set(topic.types)
            if known and not topic.missing:
                continue  # every base is reached
            try:
                await self._follow(topic)
            except RCLError:
                log.exception("the types of %s could not be followed; trying again", name)

    async def _follow(self, topic: VelocityTopic) -> None:
        await self._bridge.call(topic.update_types)
        if topic.missing:
            await asyncio.sleep(SETTLE)
        for other in await self._bridge.call(topic.arrange):
            if self._branch is None:
                self._branch = await self._bridge.branch(float("-inf"))
            await self._branch.call(partial(topic.add, self._branch, other))
