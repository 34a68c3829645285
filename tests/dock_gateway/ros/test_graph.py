"""Who is there besides gateways."""

from types import SimpleNamespace
from typing import Any

import pytest
from rclpy.qos import DurabilityPolicy, QoSProfile

from dock_gateway.ros.graph import find_presence

OWN, OTHER, DRIVER = "/dock_gateway", "/robot1/gateway2", "/driver"
BATTERY, VELOCITY, STOP = "/robot1/battery_status", "/robot1/cmd_vel", "/robot1/stop_latched"


class FakeNode:
    """A graph on which gateways are at every topic of a robot."""

    def __init__(self, publishers: dict[str, list[str]], subscribers: dict[str, list[str]], nodes: list[str]) -> None:
        self.nodes = [OWN, OTHER, *nodes]
        self.publishers = {topic: [OWN, OTHER, *publishers.get(topic, [])] for topic in (BATTERY, VELOCITY, STOP)}
        self.subscribers = {topic: [OWN, OTHER, *subscribers.get(topic, [])] for topic in (BATTERY, VELOCITY, STOP)}

    def get_fully_qualified_name(self) -> str:
        return OWN

    def get_node_names_and_namespaces(self) -> list[tuple[str, str]]:
        return [(name.rpartition("/")[2], name.rpartition("/")[0] or "/") for name in self.nodes]

    def get_publishers_info_by_topic(self, name: str) -> list[Any]:
        return [endpoint(node, latched="gateway" in node) for node in self.publishers[name]]

    def get_subscriptions_info_by_topic(self, name: str) -> list[Any]:
        return [endpoint(node) for node in self.subscribers[name]]


def endpoint(node: str, *, latched: bool = False) -> Any:
    namespace, _, name = node.rpartition("/")
    durability = DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE
    return SimpleNamespace(
        node_name=name,
        node_namespace=namespace or "/",
        topic_type="std_msgs/msg/Bool",
        qos_profile=QoSProfile(depth=1, durability=durability),
        endpoint_gid=[1] * 16,
    )


@pytest.mark.parametrize(
    ("publishers", "subscribers", "there"),
    [
        ({}, {}, False),
        ({BATTERY: [DRIVER]}, {}, True),
        ({BATTERY: ["_NODE_NAMESPACE_UNKNOWN_/_NODE_NAME_UNKNOWN_"]}, {}, True),
        ({}, {VELOCITY: [DRIVER]}, True),
        ({}, {BATTERY: [DRIVER]}, False),  # whoever only listens is not the robot
        ({}, {STOP: [DRIVER]}, False),
        ({STOP: ["/gateway3"], BATTERY: ["/gateway3"]}, {}, False),
        ({STOP: ["/e_stop"]}, {}, True),
        ({STOP: ["_NODE_NAMESPACE_UNKNOWN_/_NODE_NAME_UNKNOWN_"]}, {}, True),
    ],
)
def test_who_is_at_the_topics(publishers: dict[str, list[str]], subscribers: dict[str, list[str]], there: bool) -> None:
    node: Any = FakeNode(publishers, subscribers, [])
    presence = find_presence(node, [BATTERY, VELOCITY, STOP], stop_topic=STOP, velocity_topic=VELOCITY)
    assert (presence.publishes or presence.base) is there


def test_nodes_other_than_gateways() -> None:
    node: Any = FakeNode({}, {}, [DRIVER, "/robot1/base"])
    presence = find_presence(node, [], stop_topic=STOP, velocity_topic=VELOCITY)
    assert presence.nodes == {DRIVER, "/robot1/base"}
