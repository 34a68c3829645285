"""The action server under every benchmark; each goal says how much feedback it wants.

Goal fields: `voltage` is the rate in Hz, `capacity` the number of messages, `charge` the seconds before the first one.
A feedback message carries the time of its publication in `header.stamp`. With `location` "topic", the same messages
go to the topic `/benchmark` instead.

ROS parameters: `rate` and `count` where a goal does not say, `payload` (bytes added to each message) and `robots`:
0 serves one action in the root namespace, N serves one in each of /robot1 … /robotN.
"""

import math
import time
from typing import Any

import rclpy
from rclpy.action import ActionServer
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor, SingleThreadedExecutor
from rclpy.node import Node
from sensor_msgs.msg import BatteryState

from action_tutorials_interfaces.action import ConnectToChargingDock

ACTION = "connect_to_charging_dock"


class Server(Node):
    """Accepts every goal at once."""

    def __init__(self) -> None:
        super().__init__("benchmark_server")
        self.rate = self.declare_parameter("rate", 10.0).value
        self.count = self.declare_parameter("count", 0).value
        self.payload = "x" * self.declare_parameter("payload", 0).value
        self.robots = self.declare_parameter("robots", 0).value
        names = [f"/robot{number}/{ACTION}" for number in range(1, self.robots + 1)] or [ACTION]
        self.topic = self.create_publisher(BatteryState, "/benchmark", 1000)
        group = ReentrantCallbackGroup()
        self.servers = [
            ActionServer(self, ConnectToChargingDock, name, self.execute, callback_group=group, result_timeout=1)
            for name in names
        ]

    def execute(self, handle: Any) -> Any:
        """Publish feedback at the goal's rate, never ahead of its time, then succeed."""
        wanted = handle.request.desired_battery_state
        rate = _or(wanted.voltage, self.rate)
        count = int(_or(wanted.capacity, self.count))
        feedback = ConnectToChargingDock.Feedback()
        state = BatteryState(serial_number=self.payload, voltage=2.16, percentage=0.24, present=True)
        feedback.current_battery_state = state
        to_topic = wanted.location == "topic"
        due = time.monotonic() + _or(wanted.charge, 0.0)
        for _ in range(count):
            ahead = due - time.monotonic()
            if ahead > 0:
                time.sleep(ahead)
            due += 1 / rate
            state.header.stamp.sec, state.header.stamp.nanosec = divmod(time.time_ns(), 1_000_000_000)
            if to_topic:
                self.topic.publish(state)
            else:
                handle.publish_feedback(feedback)
        handle.succeed()
        return ConnectToChargingDock.Result(final_battery_state=state)


def _or(value: float, default: float) -> float:
    return default if math.isnan(value) or value == 0 else value


def main() -> None:
    """Serve until a signal comes."""
    rclpy.init()
    node = Server()
    # Feedback is published where the goal runs, so that one goal at a time needs one thread.
    executor = MultiThreadedExecutor(node.robots + 2) if node.robots else SingleThreadedExecutor()
    executor.add_node(node)
    print("serving", flush=True)
    try:
        executor.spin()
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
