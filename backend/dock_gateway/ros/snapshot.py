"""Reads the ROS graph for some seconds, with a node that publishes nothing."""

import time
from functools import partial
from typing import Any

import orjson
from rclpy.node import Node
from sensor_msgs.msg import BatteryState

from dock_gateway.core.battery import infinities
from dock_gateway.core.graph import ACTION_PART, STATUS
from dock_gateway.core.snapshot import GraphSnapshot
from dock_gateway.ros.bridge import starting
from dock_gateway.ros.graph import Scan, count_publishers, find_gateways, read_topic, scan
from dock_gateway.ros.listener import AnswerListener, Handler, MessageListener
from dock_gateway.ros.listening_node import ListeningNode
from dock_gateway.ros.messages.codec import codec
from dock_gateway.ros.messages.types import type_name
from dock_gateway.ros.robot_ports import FLOATS
from dock_gateway.settings import Settings
from robot_io.participants import create_context
from robot_io.qos import LATEST

# Seconds between two scans.
SCAN_INTERVAL = 0.5

States = dict[str, dict[str, Any] | None]


def take_snapshot(settings: Settings, seconds: float) -> GraphSnapshot:
    """Return what is on the graph after some seconds.

    Args:
        settings: Names.
        seconds: How long to read it.

    Raises:
        Unavailable: ROS does not start (`ros_unavailable`).
    """
    with starting():
        context = create_context([])
        messages = MessageListener("ros-messages", context, settings.max_message_bytes)
        node = ListeningNode(
            f"{settings.node_name}_doctor",
            None,
            context,
            messages,
            AnswerListener("ros-answers", context),
            enable_rosout=False,
            start_parameter_services=False,
            use_global_arguments=False,
        )
    messages.start()
    states: States = {}
    deadline = time.monotonic() + seconds
    found = Scan()
    try:
        while (left := deadline - time.monotonic()) > 0:
            found = scan(node)
            _listen(node, found, states)
            time.sleep(min(left, SCAN_INTERVAL))
        return _read(settings, node, found, states.copy(), seconds)
    finally:
        messages.close()
        node.destroy_node()
        context.try_shutdown()


def _listen(node: ListeningNode, found: Scan, states: States) -> None:
    """Subscribe to the batteries that were not seen before."""

    def hear(topic: str, message: BatteryState, _: Any) -> None:
        states[topic] = {
            **orjson.loads(codec(BatteryState).encode(message)),
            **infinities({name: getattr(message, name) for name in FLOATS}),
        }

    for topic, types in found.topics.items():
        if types == [type_name(BatteryState)] and topic not in states:
            states[topic] = None
            node.subscribe(BatteryState, topic, Handler(partial(hear, topic)), LATEST)


def _read(settings: Settings, node: Node, found: Scan, states: States, seconds: float) -> GraphSnapshot:
    stops = [topic for topic in found.topics if topic.endswith(f"/{settings.stop_state_topic.rpartition('/')[2]}")]
    ours = {node.get_fully_qualified_name()}.union(*(find_gateways(node, topic) for topic in stops))
    nodes = {f"{namespace.rstrip('/')}/{name}" for name, namespace in node.get_node_names_and_namespaces()}
    published = {
        topic: state
        for topic, state in states.items()
        if any(endpoint.node not in ours for endpoint in read_topic(node, topic).publishers)
    }
    servers = {name: count_publishers(node, f"{name}{ACTION_PART}{STATUS}") for name in found.actions}
    return GraphSnapshot(seconds, len(nodes - ours), found.actions, servers, published)
