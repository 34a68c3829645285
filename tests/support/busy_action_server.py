"""A Fibonacci action server with many goals at a time, which notes each goal that it executes.

A goal takes 0.1 to 1 s, or `--seconds`, with feedback 20 times a second. Its `order` is its number: each line of the
`--executed` file is the number of a goal that began. `--cancelable`: it cancels goals, which rclpy's servers refuse.
"""

import argparse
import contextlib
import random
import time
from pathlib import Path
from typing import Any

import rclpy
from rclpy.action import ActionServer, CancelResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor

from action_tutorials_interfaces.action import Fibonacci


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--executed", type=Path, required=True)
    parser.add_argument("--seconds", type=float)
    parser.add_argument("--cancelable", action="store_true")
    arguments = parser.parse_args()
    executed = arguments.executed.open("a", buffering=1)
    answer = CancelResponse.ACCEPT if arguments.cancelable else CancelResponse.REJECT
    rclpy.init()
    node = rclpy.create_node("busy_action_server")

    def execute(handle: Any) -> Any:
        executed.write(f"{handle.request.order}\n")
        feedback = Fibonacci.Feedback(partial_sequence=[0])
        for _ in range(int(20 * arguments.seconds) if arguments.seconds else random.randint(2, 20)):
            if handle.is_cancel_requested:
                handle.canceled()
                return Fibonacci.Result()
            handle.publish_feedback(feedback)
            time.sleep(0.05)
        handle.succeed()
        return Fibonacci.Result(sequence=[handle.request.order])

    ActionServer(
        node,
        Fibonacci,
        "fibonacci",
        execute,
        callback_group=ReentrantCallbackGroup(),
        cancel_callback=lambda _: answer,
        result_timeout=60,
    )
    executor = MultiThreadedExecutor(8)
    executor.add_node(node)
    print("serving", flush=True)
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        executor.spin()


if __name__ == "__main__":
    main()
