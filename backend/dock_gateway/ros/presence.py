"""Who is on the ROS graph besides gateways, which stay at the topics of a robot that has gone."""

from collections.abc import Iterable
from dataclasses import dataclass

from rclpy.node import Node

from dock_gateway.ros.graph import read_topic


@dataclass(frozen=True)
class Presence:
    """Who may belong to a robot.

    Attributes:
        nodes: Full names of the nodes on the graph that are no gateways.
        at_topics: Whether one of them publishes on the robot's topics, or listens to its velocity.
    """

    nodes: frozenset[str]
    at_topics: bool


def find_presence(node: Node, topics: Iterable[str], *, stop_topic: str, velocity_topic: str) -> Presence:
    """Look who is there; for the ROS thread.

    A gateway is whoever publishes on the stop topic of the robot: all others only listen to that. A program of DDS that
    is no ROS node counts as one that is there.

    Args:
        node: Our own node.
        topics: The topics of the robot.
        stop_topic: Where gateways say whether a stop is latched.
        velocity_topic: Who listens here may move.
    """
    telling = (endpoint.node for endpoint in read_topic(node, stop_topic).publishers)
    gateways = {node.get_fully_qualified_name(), *(name for name in telling if name is not None)}
    nodes = {f"{namespace.rstrip('/')}/{name}" for name, namespace in node.get_node_names_and_namespaces()}
    talking = (endpoint for topic in topics for endpoint in read_topic(node, topic).publishers)
    listening = read_topic(node, velocity_topic).subscribers
    at_topics = any(endpoint.node not in gateways for endpoint in (*listening, *talking))
    return Presence(frozenset(nodes - gateways), at_topics)
