"""What the endpoints of our nodes cost."""

from rclpy.event_handler import EventHandler
from rclpy.node import Node

from docking.core.battery import Battery
from docking.nodes.docking_server import make_servers
from docking.nodes.simulator import DockSimulator
from docking.ros.battery_subscriber import BatteryStateSubscriber
from tests.support.observer import ros_nodes


def test_an_executor_checks_no_events_of_a_robot(domain: int) -> None:
    battery = Battery()
    with ros_nodes(domain) as context:
        nodes: list[Node] = [
            *make_servers(battery, context),
            BatteryStateSubscriber(battery, context=context),
            DockSimulator(context=context),
        ]
        events = [each for node in nodes for each in node.waitables if isinstance(each, EventHandler)]
        for node in nodes:
            node.destroy_node()
    assert events == []
