"""The endpoints of a topic: who is there, and a publisher of one's own."""

from typing import Any

from rclpy.event_handler import PublisherEventCallbacks
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from rclpy.qos_overriding_options import QoSOverridingOptions
from rclpy.topic_endpoint_info import TopicEndpointInfo


def node_name(info: TopicEndpointInfo) -> str:
    """The full name of an endpoint's node; empty until ROS knows it."""
    if info.node_name.startswith("_NODE_NAME_UNKNOWN_"):
        return ""
    return f"{info.node_namespace.rstrip('/')}/{info.node_name}"


def busy_publisher(node: Node, message_type: Any, topic: str, qos: QoSProfile | int = 10) -> Publisher:
    """A publisher of a node that publishes often.

    The executor would check each event of a publisher at every tick, so it has none; a subscription that does not match
    warns by itself.

    Args:
        node: The node that publishes.
        message_type: The type of the messages.
        topic: The name of the topic.
        qos: The quality of service, or its depth.
    """
    return node.create_publisher(
        message_type,
        topic,
        qos,
        qos_overriding_options=QoSOverridingOptions.with_default_policies(),
        event_callbacks=PublisherEventCallbacks(use_default_callbacks=False),
    )
