"""Finds second nodes where there must be only one: two publishers of odometry, or two bases on one `cmd_vel`."""

from collections.abc import Iterable

from rclpy.node import Node
from rclpy.topic_endpoint_info import TopicEndpointInfo

from docking.core.errors import ErrorCode
from docking.ros.velocity_publisher import TOPIC as CMD_VEL
from robot_io.endpoints import node_name

ODOMETRY_TYPE = "nav_msgs/msg/Odometry"
PARTICIPANT = 12
"""Bytes of an endpoint's id that are those of its participant: two nodes of one name are in two."""
DRIVEN = frozenset(
    {
        ErrorCode.BLOCKED,
        ErrorCode.PUSHED_OFF,
        ErrorCode.FAILED_TO_CONTROL,
        ErrorCode.FAILED_TO_STAGE,
        ErrorCode.FAILED_TO_CHARGE,
        ErrorCode.FAILED_TO_UNDOCK,
        ErrorCode.TIMEOUT,
    }
)
"""Errors that rivals may cause, in addition to those that a sensor's fault may cause."""


class Rivals:
    """Looks for them, and warns.

    A base is a node that subscribes to `cmd_vel` and publishes odometry, under whatever name.

    Attributes:
        faults: Topics with too many nodes: a sentence each.
    """

    def __init__(self, node: Node) -> None:
        self.faults: dict[str, str] = {}
        self._node = node

    def scan(self) -> None:
        """Scan the graph; call it before the robot drives, and once a second."""
        self.faults = _find(self._node)
        if self.faults:
            self._node.get_logger().warning("; ".join(self.faults.values()), throttle_duration_sec=10.0)


def _find(node: Node) -> dict[str, str]:
    faults: dict[str, str] = {}
    odometry, cmd_vel = node.resolve_topic_name("odom"), node.resolve_topic_name(CMD_VEL)
    sources = _distinct(node.get_publishers_info_by_topic(odometry))
    advice = "Give each robot a namespace, or remap all but one"
    if len(sources) > 1:
        faults[odometry] = (
            f"{odometry} has {len(sources)} publishers, {_listed(sources)}, but a robot has one odometry. {advice}"
        )
    listeners = _distinct(node.get_subscriptions_info_by_topic(cmd_vel))
    if len(listeners) < 2:
        return faults
    measuring = {
        name
        for topic, types in node.get_topic_names_and_types()
        if ODOMETRY_TYPE in types
        for name, _ in _distinct(node.get_publishers_info_by_topic(topic))
    }
    bases = {(name, participant) for name, participant in listeners if name in measuring}
    if len(bases) > 1:
        faults[cmd_vel] = f"{cmd_vel} drives {len(bases)} bases, {_listed(bases)}: each goal moves them all. {advice}"
    return faults


def _distinct(endpoints: Iterable[TopicEndpointInfo]) -> set[tuple[str, bytes]]:
    """The nodes whose names are known, with their participants."""
    return {(name, bytes(end.endpoint_gid[:PARTICIPANT])) for end in endpoints if (name := node_name(end))}


def _listed(nodes: Iterable[tuple[str, bytes]]) -> str:
    return " and ".join(sorted(name for name, _ in nodes))
