"""Looks at the ROS graph for some seconds, with a node that publishes nothing."""

import time
from functools import partial
from typing import Any

import orjson
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from sensor_msgs.msg import BatteryState

from dock_gateway.core.battery import infinities
from dock_gateway.core.graph import ACTION_PART, STATUS
from dock_gateway.core.snapshot import GraphSnapshot
from dock_gateway.ros.bridge import starting
from dock_gateway.ros.graph import Scan, count_publishers, find_gateways, read_topic, scan
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
        seconds: How long to look.

    Raises:
        Unavailable: ROS does not start (`ros_unavailable`).
    """
    with starting():
        context = create_context([])
        node = Node(
            f"{settings.node_name}_doctor",
            context=context,
            enable_rosout=False,
            start_parameter_services=False,
            use_global_arguments=False,
        )
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    states: States = {}
    deadline, scan_at = time.monotonic() + seconds, 0.0
    found = Scan()
    try:
        while (now := time.monotonic()) < deadline:
            if now >= scan_at:
                found, scan_at = scan(node), now + SCAN_INTERVAL
                _listen(node, found, states)
            executor.spin_once(timeout_sec=0.1)
        return _read(settings, node, found, states, seconds)
    finally:
        executor.shutdown()
        node.destroy_node()
        context.try_shutdown()


def _listen(node: Node, found: Scan, states: States) -> None:
    """Subscribe to the batteries that were not seen before."""

    def hear(topic: str, message: BatteryState) -> None:
        states[topic] = {
            **orjson.loads(codec(BatteryState).encode(message)),
            **infinities({name: getattr(message, name) for name in FLOATS}),
        }

    for topic, types in found.topics.items():
        if types == [type_name(BatteryState)] and topic not in states:
            states[topic] = None
            node.create_subscription(BatteryState, topic, partial(hear, topic), LATEST)


def _read(settings: Settings, node: Node, found: Scan, states: States, seconds: float) -> GraphSnapshot:
    stops = [topic for topic in found.topics if topic.endswith(f"/{settings.stop_topic.rpartition('/')[2]}")]
    ours = {node.get_fully_qualified_name()}.union(*(find_gateways(node, topic) for topic in stops))
    nodes = {f"{namespace.rstrip('/')}/{name}" for name, namespace in node.get_node_names_and_namespaces()}
    published = {
        topic: state
        for topic, state in states.items()
        if any(endpoint.node not in ours for endpoint in read_topic(node, topic).publishers)
    }
    servers = {name: count_publishers(node, f"{name}{ACTION_PART}{STATUS}") for name in found.actions}
    return GraphSnapshot(seconds, len(nodes - ours), found.actions, servers, published)
