"""Nodes that talk: `--nodes` of them in namespaces /talker0, /talker1 …, the first of which publishes `--messages`.

Each node has a publisher and a subscription of `sensor_msgs/BatteryState` on `battery_status` in its namespace. Of the
topics `--topic name:type:rate` the first node sends the given message type so often; `latched` for a rate publishes
once, for whoever comes later.
"""

import argparse
import contextlib
import importlib
from typing import Any

import rclpy
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from sensor_msgs.msg import BatteryState

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--nodes", type=int, default=1)
    parser.add_argument("--topic", action="append", default=[], help="name:package/msg/Type:rate")
    parser.add_argument("--long", type=int, default=0, help="items of a field called ranges")
    arguments = parser.parse_args()
    rclpy.init()
    executor = SingleThreadedExecutor()
    nodes = [rclpy.create_node("talker", namespace=f"/talker{number}") for number in range(arguments.nodes)]
    for node in nodes:
        node.create_publisher(BatteryState, "battery_status", qos_profile_sensor_data)
        node.create_subscription(BatteryState, "battery_status", lambda _: None, 10)
        executor.add_node(node)
    for text in arguments.topic:
        talk(nodes[0], *text.split(":"), arguments.long)
    print("talking", flush=True)
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        executor.spin()


def talk(node: Node, name: str, kind: str, rate: str, long: int) -> None:
    package, _, type_name = kind.split("/")
    message: Any = getattr(importlib.import_module(f"{package}.msg"), type_name)()
    if hasattr(message, "ranges"):
        message.ranges = [float(index) for index in range(long)]
    if rate == "latched":
        node.create_publisher(type(message), name, LATCHED).publish(message)
        return
    publisher = node.create_publisher(type(message), name, qos_profile_sensor_data)
    node.create_timer(1 / float(rate), lambda: publisher.publish(message))


if __name__ == "__main__":
    main()
