"""Reads the ROS graph: a quick scan of actions and topics with their types, or a full survey in steps."""

import re
import time
from collections import Counter
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field

from rclpy.duration import Duration
from rclpy.exceptions import InvalidServiceNameException, InvalidTopicNameException
from rclpy.node import Node, NodeNameNonExistentError
from rclpy.qos import HistoryPolicy, QoSProfile
from rclpy.topic_endpoint_info import TopicEndpointInfo

from dock_gateway.core.filters import is_under
from dock_gateway.core.graph import (
    ACTION_PART,
    FEEDBACK,
    FEEDBACK_TYPE,
    STATUS,
    Endpoint,
    GraphScan,
    Quality,
    Service,
    Topic,
)
from dock_gateway.setting_types import ROS_TOKEN
from robot_io.endpoints import node_name

# Seconds of a survey step on the ROS thread.
PIECE = 0.002
INFINITE_NS = 2**63 - 1
# The type of stop topics.
STOP_TYPE = "std_msgs/msg/Bool"
TOPIC_NAME = re.compile(f"(/{ROS_TOKEN.pattern})+")


@dataclass(frozen=True)
class Scan:
    """The result of one scan of the graph.

    Attributes:
        actions: Names of the actions that have a server, with their types (more than one is a fault on the graph).
        topics: Names of topics, without those of actions, with their types.
    """

    actions: dict[str, list[str]] = field(default_factory=dict)
    topics: dict[str, list[str]] = field(default_factory=dict)


def scan(node: Node) -> Scan:
    """Scan the graph; call it on the ROS thread.

    An action is on the graph as soon as any node, including ours, subscribes to it. It has a server only if its status
    has a publisher.
    """
    result = Scan()
    for topic, types in node.get_topic_names_and_types():
        name, separator, part = topic.partition(ACTION_PART)
        if not TOPIC_NAME.fullmatch(name):  # a DDS program that is not a ROS node may use any name
            continue
        if not separator:
            result.topics[topic] = list(types)
        elif (
            part == FEEDBACK
            and (found := _action_types(types))
            and count_publishers(node, f"{name}{ACTION_PART}{STATUS}")
        ):
            result.actions[name] = found if len(found) == 1 else _server_types(node, topic) or found
    return result


def _action_types(types: Iterable[str]) -> list[str]:
    """Return the types of an action by those of its feedback; other topics may have such a name, too."""
    return [text.removesuffix(FEEDBACK_TYPE) for text in types if text.endswith(FEEDBACK_TYPE)]


def _server_types(node: Node, feedback: str) -> list[str]:
    """Return the types of an action's servers: it may have clients, such as ourselves, with another one."""
    return _action_types(sorted({info.topic_type for info in node.get_publishers_info_by_topic(feedback)}))


def count_publishers(node: Node, topic: str) -> int:
    """Return the number of publishers of a topic; on the ROS thread."""
    try:
        return int(node.count_publishers(topic))
    except InvalidTopicNameException:  # the name is too long
        return 0


def count_subscribers(node: Node, topic: str) -> int:
    """Return the number of subscriptions of a topic; on the ROS thread."""
    try:
        return int(node.count_subscribers(topic))
    except InvalidTopicNameException:  # the name is too long
        return 0


class Survey:
    """A survey of the whole graph in steps, between which the ROS thread does other work.

    Args:
        node: Of the graph.
        piece: Seconds that one step takes.

    Attributes:
        seen: The results so far.
    """

    def __init__(self, node: Node, piece: float = PIECE) -> None:
        self._piece = piece
        self.seen = GraphScan()
        self._node = node
        self._steps = self._scan()

    def proceed(self) -> bool:
        """Run one step; return whether the survey is complete. Call it on the ROS thread."""
        until = time.perf_counter() + self._piece
        return all(time.perf_counter() < until for _ in self._steps)

    def _scan(self) -> Iterator[None]:
        nodes = self._node.get_node_names_and_namespaces()
        self.seen.nodes = dict(Counter(_full_name(name, namespace) for name, namespace in nodes))
        for name, types in self._node.get_service_names_and_types():
            self.seen.services[name] = Service(name, list(types))
        yield
        for name, _ in self._node.get_topic_names_and_types():
            self.seen.topics[name] = read_topic(self._node, name)
            yield
        for name, namespace in dict.fromkeys(nodes):
            self._scan_services(name, namespace)
            yield

    def _scan_services(self, name: str, namespace: str) -> None:
        try:
            served = self._node.get_service_names_and_types_by_node(name, namespace)
            used = self._node.get_client_names_and_types_by_node(name, namespace)
        except NodeNameNonExistentError:  # the node has left since
            return
        node = _full_name(name, namespace)
        for service, types in served:
            self.seen.services.setdefault(service, Service(service, list(types))).servers.add(node)
        for service, types in used:
            self.seen.services.setdefault(service, Service(service, list(types))).clients.add(node)


def read_topic(node: Node, name: str) -> Topic:
    """Return the endpoints of a topic, none if it does not exist or its name is invalid; on the ROS thread."""
    if not TOPIC_NAME.fullmatch(name):
        return Topic(name, [], [])
    try:
        publishers, subscribers = node.get_publishers_info_by_topic(name), node.get_subscriptions_info_by_topic(name)
    except InvalidTopicNameException:  # the name is too long
        return Topic(name, [], [])
    return Topic(name, [_endpoint(info) for info in publishers], [_endpoint(info) for info in subscribers])


def read_topics(node: Node, types: frozenset[str], namespace: str) -> list[Topic]:
    """Return the topics in a namespace that have one of these types, with their endpoints; on the ROS thread."""
    found = node.get_topic_names_and_types()
    return [read_topic(node, name) for name, of in found if is_under(name, namespace) and not types.isdisjoint(of)]


def read_service(node: Node, name: str) -> list[str]:
    """Return the types of a service's servers, none if it has no server or its name is invalid; on the ROS thread.

    Which nodes serve it is asked for only if there are several types, as a client that waits for it has one, too.
    """
    if not TOPIC_NAME.fullmatch(name) or not _count_services(node, name):
        return []
    types = sorted(next((types for known, types in node.get_service_names_and_types() if known == name), ()))
    return types if len(types) < 2 else _served_types(node, name) or types


def _served_types(node: Node, name: str) -> list[str]:
    found = set[str]()
    for peer, namespace in dict.fromkeys(node.get_node_names_and_namespaces()):
        with suppress(NodeNameNonExistentError):  # the node has left since
            served = node.get_service_names_and_types_by_node(peer, namespace)
            found.update(*(types for known, types in served if known == name))
    return sorted(found)


def _count_services(node: Node, name: str) -> int:
    try:
        return int(node.count_services(name))
    except InvalidServiceNameException:  # the name is too long
        return 0


def service_names(node: Node) -> list[str]:
    """Return the names of all services; on the ROS thread."""
    return [name for name, _ in node.get_service_names_and_types()]


def topic_names(node: Node) -> list[str]:
    """Return the names of all topics; on the ROS thread."""
    return [name for name, _ in node.get_topic_names_and_types()]


def node_names(node: Node) -> list[str]:
    """Return the full names of all nodes; on the ROS thread."""
    return [_full_name(name, namespace) for name, namespace in node.get_node_names_and_namespaces()]


def _endpoint(info: TopicEndpointInfo) -> Endpoint:
    return Endpoint(node_name(info) or None, info.topic_type, _quality(info.qos_profile), bytes(info.endpoint_gid))


def _full_name(name: str, namespace: str) -> str:
    return f"{namespace.rstrip('/')}/{name}"


def _quality(profile: QoSProfile) -> Quality:
    # DDS does not publish the history depth of an endpoint.
    depth = None if profile.history in (HistoryPolicy.UNKNOWN, HistoryPolicy.KEEP_ALL) else profile.depth
    return Quality(
        reliability=profile.reliability.name.lower(),
        durability=profile.durability.name.lower(),
        history=profile.history.name.lower(),
        depth=depth,
        deadline_s=_seconds(profile.deadline),
        lifespan_s=_seconds(profile.lifespan),
        liveliness=profile.liveliness.name.lower(),
    )


def _seconds(duration: Duration) -> float | None:
    nanoseconds: int = duration.nanoseconds
    return None if nanoseconds in (0, INFINITE_NS) else nanoseconds / 1e9


@dataclass(frozen=True)
class Presence:
    """The nodes that may belong to a robot.

    Attributes:
        nodes: Full names of the nodes on the graph that are not gateways.
        publishes: Whether one of them publishes on the robot's topics.
        base: Whether one of them subscribes to its velocity.
    """

    nodes: frozenset[str]
    publishes: bool
    base: bool


def find_gateways(node: Node, stop_topic: str) -> frozenset[str]:
    """Return the nodes of gateways: our own, and who publishes on a stop topic and keeps what it said.

    Call it on the ROS thread.
    """
    telling = (
        endpoint.node
        for endpoint in read_topic(node, stop_topic).publishers
        if endpoint.qos.durability == "transient_local" and endpoint.type == STOP_TYPE
    )
    return frozenset({node.get_fully_qualified_name(), *(name for name in telling if name is not None)})


def find_presence(node: Node, topics: Iterable[str], *, stop_topic: str, velocity_topic: str) -> Presence:
    """Find the nodes that may belong to a robot; call it on the ROS thread.

    A DDS program that is not a ROS node counts as present.

    Args:
        node: Our own node.
        topics: The topics of the robot.
        stop_topic: The topic on which gateways publish whether a stop is latched.
        velocity_topic: The topic whose subscribers may move.
    """
    gateways = find_gateways(node, stop_topic)
    nodes = {f"{namespace.rstrip('/')}/{name}" for name, namespace in node.get_node_names_and_namespaces()}
    talking = (endpoint for topic in topics for endpoint in read_topic(node, topic).publishers)
    listening = read_topic(node, velocity_topic).subscribers
    publishes = any(endpoint.node not in gateways for endpoint in talking)
    base = any(endpoint.node not in gateways for endpoint in listening)
    return Presence(frozenset(nodes - gateways), publishes, base)
