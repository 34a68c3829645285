"""Robots that stand about: battery states, and for a single one a velocity that lets its simulator drive in a circle.

ROS parameters: `robots` (0 is one in the root namespace, N is /robot1 … /robotN), `rate` in Hz, and `drive`.
"""

import math
import time
from contextlib import suppress

import rclpy
from geometry_msgs.msg import Twist
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import BatteryState

SPEED, TURN = 0.1, 0.4  # m/s and rad/s


class Fleet(Node):
    """Publishes for all of them from one timer."""

    def __init__(self) -> None:
        super().__init__("benchmark_fleet")
        robots = self.declare_parameter("robots", 0).value
        rate = self.declare_parameter("rate", 2.0).value
        names = [f"/robot{number}/" for number in range(1, robots + 1)] or ["/"]
        self.batteries = [self.create_publisher(BatteryState, f"{name}battery_status", 10) for name in names]
        self.velocity = (
            self.create_publisher(Twist, "/cmd_vel", 10) if self.declare_parameter("drive", False).value else None
        )
        self.begun = time.monotonic()
        self.create_timer(1 / rate, self.publish)

    def publish(self) -> None:
        """One message of each robot, each a little different."""
        seconds = time.monotonic() - self.begun
        for number, publisher in enumerate(self.batteries):
            level = 0.6 + 0.3 * math.sin(seconds / 60 + number)
            publisher.publish(
                BatteryState(
                    voltage=11.0 + 1.5 * level,
                    percentage=level,
                    current=-0.8 + 0.2 * math.sin(seconds * 3 + number),
                    temperature=25.0 + 2 * math.sin(seconds / 20),
                    power_supply_status=BatteryState.POWER_SUPPLY_STATUS_DISCHARGING,
                    present=True,
                )
            )
        if self.velocity is not None:
            twist = Twist()
            twist.linear.x, twist.angular.z = SPEED, TURN
            self.velocity.publish(twist)


def main() -> None:
    """Publish until a signal comes."""
    rclpy.init(signal_handler_options=SignalHandlerOptions.ALL)
    node = Fleet()
    print("publishing", flush=True)
    with suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(node)


if __name__ == "__main__":
    main()
