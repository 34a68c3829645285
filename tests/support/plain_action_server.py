"""An action server that is not ours: rclpy's ActionServer as the official tutorial uses it, blocking while it works.

Sends `--feedbacks` feedback messages, 20 a second, and succeeds with the state that was desired. Rejects a desired
status of 9, aborts one of 8, without a word about why.
"""

import argparse
import contextlib
import time
from typing import Any

import rclpy
from rclpy.action import ActionServer, GoalResponse

from action_tutorials_interfaces.action import ConnectToChargingDock


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--feedbacks", type=int, default=10)
    parser.add_argument("--result-bytes", type=int, default=0, help="bytes of a result")
    arguments = parser.parse_args()
    rclpy.init()
    node = rclpy.create_node("plain_action_server")

    def decide(goal: Any) -> GoalResponse:
        status = goal.desired_battery_state.power_supply_status
        return GoalResponse.REJECT if status == 9 else GoalResponse.ACCEPT

    def execute(handle: Any) -> Any:
        feedback = ConnectToChargingDock.Feedback()
        for count in range(arguments.feedbacks):
            feedback.current_battery_state.percentage = count / 100
            handle.publish_feedback(feedback)
            time.sleep(0.05)
        desired = handle.request.desired_battery_state
        desired.cell_voltage = [3.7] * (arguments.result_bytes // 4)
        result = ConnectToChargingDock.Result(final_battery_state=desired)
        if desired.power_supply_status == 8:
            handle.abort()
        else:
            handle.succeed()
        return result

    ActionServer(node, ConnectToChargingDock, "connect_to_charging_dock", execute, goal_callback=decide)
    print("serving", flush=True)
    with contextlib.suppress(KeyboardInterrupt, rclpy.executors.ExternalShutdownException):
        rclpy.spin(node)


if __name__ == "__main__":
    main()
