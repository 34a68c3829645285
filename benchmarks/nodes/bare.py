"""What ROS itself costs: rclpy's own ActionClient, told what to do by lines of JSON on its standard input.

{"do": "goal"}                                     one goal; answers with the times to acceptance and result
{"do": "stream", "goal": {…}}                      one goal with feedback; answers with the latencies
{"do": "robots", "goal": {…}, "names": […]}        one such goal on each of these actions
"""

import json
import sys
import time
from typing import Any

import rclpy
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.task import Future
from sensor_msgs.msg import BatteryState

from action_tutorials_interfaces.action import ConnectToChargingDock

ACTION = "connect_to_charging_dock"
LINGER = 1.0


class Bare(Node):
    """One client an action."""

    def __init__(self) -> None:
        super().__init__("benchmark_bare_client")
        self.executor_ = SingleThreadedExecutor()
        self.executor_.add_node(self)
        self.clients_by_name: dict[str, ActionClient] = {}
        self.latencies: list[float] = []
        self.stamps: list[int] = []

    def client(self, name: str) -> ActionClient:
        """The client of an action, once its server is there."""
        if name not in self.clients_by_name:
            self.clients_by_name[name] = ActionClient(self, ConnectToChargingDock, name)
        if not self.clients_by_name[name].wait_for_server(20.0):
            raise TimeoutError(name)
        return self.clients_by_name[name]

    def wait(self, future: Future, timeout: float = 30.0) -> Any:
        """Spin until a future is done."""
        self.executor_.spin_until_future_complete(future, timeout)
        return future.result()

    def settle(self, seconds: float = 0.05) -> None:
        """Hear all there is to hear of earlier goals."""
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0:
            self.executor_.spin_once(left)

    def hear(self, message: Any) -> None:
        """Note when a feedback message arrived."""
        now = time.time_ns()
        stamp = message.feedback.current_battery_state.header.stamp
        sent = stamp.sec * 1_000_000_000 + stamp.nanosec
        self.latencies.append((now - sent) / 1e6)
        self.stamps.append(sent)

    def goal(self) -> dict[str, Any]:
        """Submit a goal and wait for its result."""
        client = self.client(ACTION)
        message = ConnectToChargingDock.Goal()
        self.settle()
        start = time.perf_counter()
        handle = self.wait(client.send_goal_async(message))
        accepted = time.perf_counter()
        self.wait(handle.get_result_async())
        return {"accepted": (accepted - start) * 1e3, "result": (time.perf_counter() - start) * 1e3}

    def stream(self, goal: dict[str, float], names: list[str]) -> dict[str, Any]:
        """Read the feedback of one goal on each action."""
        self.latencies, self.stamps = [], []
        clients = [self.client(name) for name in names]
        message = ConnectToChargingDock.Goal(desired_battery_state=BatteryState(**goal))
        handles = [self.wait(client.send_goal_async(message, feedback_callback=self.hear)) for client in clients]
        for handle in handles:
            self.wait(handle.get_result_async(), 60.0)
        end = time.monotonic() + LINGER  # what is on its way may still come
        while time.monotonic() < end and len(self.latencies) < goal["capacity"] * len(names):
            self.executor_.spin_once(0.05)
        return {"latencies": self.latencies, "received": len(self.latencies), "stamps": self.stamps}


def main() -> None:
    """Answer each line until the input ends."""
    rclpy.init()
    node = Bare()
    print(json.dumps({"ready": True}), flush=True)
    for line in sys.stdin:
        order = json.loads(line)
        if order["do"] == "goal":
            answer = node.goal()
        elif order["do"] == "robots":
            answer = node.stream(order["goal"], order["names"])
        else:
            answer = node.stream(order["goal"], [ACTION])
        print(json.dumps(answer), flush=True)
    rclpy.try_shutdown()


if __name__ == "__main__":
    main()
