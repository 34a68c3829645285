"""A battery driver: publishes the tutorial's state with the status that is named, five times a second."""

import contextlib
import sys

import rclpy
from rclpy.executors import ExternalShutdownException
from sensor_msgs.msg import BatteryState


def main() -> None:
    rclpy.init()
    node = rclpy.create_node("battery_driver")
    publisher = node.create_publisher(BatteryState, "battery_status", 10)
    state = BatteryState(voltage=2.16, percentage=0.24, power_supply_status=int(sys.argv[1]))
    node.create_timer(0.2, lambda: publisher.publish(state))
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(node)


if __name__ == "__main__":
    main()
