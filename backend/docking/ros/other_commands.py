"""Hears whether other nodes drive the robot: they command a motion on `cmd_vel`."""

import math
from contextlib import suppress

from rclpy.node import Node
from rclpy.qos_overriding_options import QoSOverridingOptions
from rclpy.serialization import deserialize_message
from rclpy.subscription import Subscription

from docking.ros.velocity_publisher import TOPIC
from robot_io.endpoints import node_name
from robot_io.qos import LISTEN
from robot_io.rclpy_private import Buffer, NotForExecutors, RCLError, SubscriptionWaitable
from robot_io.reception import arrived_at
from robot_io.velocity import CLASSES, is_motion


class OtherCommands:
    """Watches for motions that another node commands.

    It subscribes only where another node publishes. All calls must come from the thread that spins the node.

    Attributes:
        heard_at: When that arrived, in seconds of the monotonic clock; any thread may read it.
    """

    def __init__(self, node: Node) -> None:
        """Hear nothing yet.

        Args:
            node: The node that drives the robot, too.
        """
        self.heard_at = -math.inf
        self._node = node
        self._own: set[bytes] = set()
        self._waitables: dict[str, SubscriptionWaitable] = {}
        self._buffer = Buffer()

    def listen(self) -> None:
        """Subscribe to the types that others publish, unless that is done."""
        for name in sorted(self._scan() & CLASSES.keys() - self._waitables.keys()):
            with suppress(RCLError):  # the node's DDS participant has the topic with another type
                self._subscribe(name)

    def _scan(self) -> set[str]:
        """The types that others publish."""
        publishers = self._node.get_publishers_info_by_topic(TOPIC)
        own = self._node.get_fully_qualified_name()
        self._own = {bytes(info.endpoint_gid) for info in publishers if node_name(info) == own}
        return {info.topic_type for info in publishers if node_name(info) != own}

    def _subscribe(self, name: str) -> None:
        overriding = QoSOverridingOptions.with_default_policies()
        subscription = self._node.create_subscription(
            CLASSES[name], TOPIC, _ignore, LISTEN, callback_group=NotForExecutors(), qos_overriding_options=overriding
        )
        self._waitables[name] = SubscriptionWaitable(subscription, lambda: self._hear(subscription))
        self._node.add_waitable(self._waitables[name])

    def _hear(self, subscription: Subscription) -> None:
        with subscription.handle:
            while self._buffer.take(subscription):
                publisher = self._buffer.info["publisher"]
                if publisher not in self._own and is_motion(
                    deserialize_message(self._buffer.read(), subscription.msg_type)
                ):
                    self._scan()  # a publisher of our own may be new
                    if publisher not in self._own:
                        self.heard_at = max(self.heard_at, arrived_at(self._buffer.info))

    def leave(self) -> None:
        """Unsubscribe."""
        for waitable in self._waitables.values():
            self._node.remove_waitable(waitable)
            self._node.destroy_subscription(waitable.subscription)
        self._waitables = {}


def _ignore(_: object) -> None:
    """Take nothing: `SubscriptionWaitable` does."""
