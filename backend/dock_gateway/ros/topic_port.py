"""Publishes on any topic."""

import asyncio

from rclpy.exceptions import InvalidTopicNameException
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, QoSProfile

from dock_gateway.core.errors import Conflict, Unavailable
from dock_gateway.ros.bridge import Bridge
from dock_gateway.ros.messages.types import MessageClass
from dock_gateway.ros.service_client import SETTLE
from robot_io.rclpy_private import InvalidHandle, RCLError

# Messages that are kept for subscribers that ask for earlier ones, and for those that have to be sent again.
DEPTH = 10
# Seconds to wait until the subscribers that are there are reached.
REACH_WITHIN = 1.0


class TopicPort:
    """A publisher of one topic, made on the ROS thread.

    Args:
        bridge: The bridge to the ROS thread.
        topic: Absolute name.
        message_class: The type of its messages.
        latched: Whether late subscribers get the last messages.

    Raises:
        Conflict: `topic_in_use`: the gateway itself uses the topic with another type.

    Attributes:
        open: Whether it publishes still.
    """

    def __init__(self, bridge: Bridge, topic: str, message_class: MessageClass, *, latched: bool) -> None:
        durability = DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE
        self._bridge = bridge
        self.open = True
        try:
            self._publisher: Publisher = bridge.node.create_publisher(
                message_class, topic, QoSProfile(depth=DEPTH, durability=durability)
            )
        except (RCLError, InvalidTopicNameException) as error:
            detail = f"the gateway itself uses {topic} with another type, or ROS does not take its name"
            raise Conflict(detail, code="topic_in_use") from error

    @property
    def subscribers(self) -> int:
        """The number of subscriptions that a message reaches."""
        try:
            return int(self._publisher.get_subscription_count())
        except InvalidHandle:
            return 0

    async def reach(self, subscribers: int) -> None:
        """Wait a short time until that many subscriptions are reached. An earlier message would be lost."""
        if not subscribers:
            return
        try:
            async with asyncio.timeout(REACH_WITHIN):
                while self.subscribers < subscribers:  # noqa: ASYNC110 - DDS has no event for that
                    await asyncio.sleep(0.02)
        except TimeoutError:  # their quality of service may be another one
            pass
        await asyncio.sleep(SETTLE)

    def publish(self, message: object) -> None:
        """Publish a message, at once: called on the loop.

        Raises:
            Unavailable: `ros_unavailable`: the publisher is gone.
        """
        try:
            self._publisher.publish(message)
        except (InvalidHandle, RCLError) as error:
            raise Unavailable(f"the message was not published: {error}", code="ros_unavailable") from error

    def close(self) -> None:
        """Leave the topic; what was not delivered yet is dropped. Called on the loop."""
        self.open = False
        self._bridge.to_ros(lambda: self._bridge.node.destroy_publisher(self._publisher))
