"""Who is at a topic."""

from rclpy.topic_endpoint_info import TopicEndpointInfo


def node_name(info: TopicEndpointInfo) -> str:
    """The full name of an endpoint's node; empty until ROS knows it."""
    if info.node_name.startswith("_NODE_NAME_UNKNOWN_"):
        return ""
    return f"{info.node_namespace.rstrip('/')}/{info.node_name}"
