"""A node that serves an action, and has one parameter: `python -m … 0.25`."""

import sys

import rclpy
from rclpy.action import ActionServer

from action_tutorials_interfaces.action import DisconnectFromChargingDock as Undock

ACTION, NODE = "/leave", "/worker"


def main() -> None:
    rclpy.init()
    node = rclpy.create_node(NODE.strip("/"))
    node.declare_parameter("speed", float(sys.argv[1]))
    server = ActionServer(node, Undock, ACTION, lambda _: Undock.Result())
    rclpy.spin(node)
    server.destroy()


if __name__ == "__main__":
    main()
