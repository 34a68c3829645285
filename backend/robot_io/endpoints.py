"""The endpoints of a topic: who is there, and a publisher of one's own."""

from typing import Any

from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from rclpy.qos_overriding_options import QoSOverridingOptions
from rclpy.subscription import Subscription
from rclpy.topic_endpoint_info import TopicEndpointInfo


def node_name(info: TopicEndpointInfo) -> str:
    """The full name of an endpoint's node; empty until ROS knows it."""
    if info.node_name.startswith("_NODE_NAME_UNKNOWN_"):
        return ""
    return f"{info.node_namespace.rstrip('/')}/{info.node_name}"


class WithoutEvents:
    """A mixin for nodes: no publisher and no subscription has event callbacks, not even those that rclpy makes.

    The executor would check each of them whenever anything happens, which is half of what a node costs, and would wake
    up for each message of a subscription that it leaves to others. The callbacks would warn of an endpoint that does
    not match: the node of that endpoint warns as well.
    """

    def create_publisher(self, *args: Any, **options: Any) -> Publisher:
        """Like rclpy's."""
        options["event_callbacks"] = PublisherEventCallbacks(use_default_callbacks=False)
        return super().create_publisher(*args, **options)  # type: ignore[misc]

    def create_subscription(self, *args: Any, **options: Any) -> Subscription:
        """Like rclpy's."""
        options["event_callbacks"] = SubscriptionEventCallbacks(use_default_callbacks=False)
        return super().create_subscription(*args, **options)  # type: ignore[misc]


def overridable_publisher(node: Node, message_type: Any, topic: str, qos: QoSProfile | int = 10) -> Publisher:
    """A publisher whose quality of service the node's parameters can override.

    Args:
        node: The node that publishes.
        message_type: The type of the messages.
        topic: The name of the topic.
        qos: The quality of service, or its depth.
    """
    return node.create_publisher(
        message_type, topic, qos, qos_overriding_options=QoSOverridingOptions.with_default_policies()
    )
