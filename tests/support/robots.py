"""Robots that stand about, in one process: `--robots` of them, /robot1 …, each with the topics that a stop is about.

Each publishes its battery on `battery_status` once a second and listens to `cmd_vel` and `stop_latched`. Whenever the
number of those that were told to stand still or are latched has changed: `halted <robots> latched <robots>`.
"""

import argparse
import contextlib

import rclpy
from geometry_msgs.msg import Twist
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import BatteryState
from std_msgs.msg import Bool

# Hundreds of entities that an executor waits for the events of would take a core.
QUIET = SubscriptionEventCallbacks(use_default_callbacks=False)
QUIET_PUBLISHER = PublisherEventCallbacks(use_default_callbacks=False)
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Robots(Node):
    """All of them."""

    def __init__(self, count: int) -> None:
        super().__init__("robots")
        self.halted: set[str] = set()
        self.latched: set[str] = set()
        self.said = ""
        self.batteries = []
        for name in (f"/robot{number}" for number in range(1, count + 1)):
            battery = f"{name}/battery_status"
            self.batteries.append(self.create_publisher(BatteryState, battery, 10, event_callbacks=QUIET_PUBLISHER))
            self.create_subscription(Twist, f"{name}/cmd_vel", self.halt(name), 10, event_callbacks=QUIET)
            self.create_subscription(Bool, f"{name}/stop_latched", self.latch(name), LATCHED, event_callbacks=QUIET)
        self.create_timer(1.0, self.publish)
        self.create_timer(0.2, self.say)

    def halt(self, name: str):
        return lambda _: self.halted.add(name)

    def latch(self, name: str):
        return lambda message: (self.latched.add if message.data else self.latched.discard)(name)

    def publish(self) -> None:
        for publisher in self.batteries:
            publisher.publish(BatteryState(voltage=12.0, percentage=0.5, power_supply_status=2))

    def say(self) -> None:
        text = f"halted {len(self.halted)} latched {len(self.latched)}"
        if text != self.said:
            self.said = text
            print(text, flush=True)


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--robots", type=int, default=1)
    arguments = parser.parse_args()
    rclpy.init()
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(Robots(arguments.robots))


if __name__ == "__main__":
    main()
