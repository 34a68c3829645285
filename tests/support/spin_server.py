"""An action server `/spin` whose type is an argument. Goals run for as many seconds as the second argument says."""

import contextlib
import sys
import time
from typing import Any

import rclpy
from rclpy.action import ActionServer

from action_tutorials_interfaces import action


def main() -> None:
    kind, seconds = getattr(action, sys.argv[1]), float(sys.argv[2])
    rclpy.init()
    node = rclpy.create_node(f"spin_{sys.argv[1].lower()}")

    def execute(handle: Any) -> Any:
        time.sleep(seconds)
        handle.succeed()
        return kind.Result()

    ActionServer(node, kind, "/spin", execute)
    print("serving", flush=True)
    with contextlib.suppress(KeyboardInterrupt, rclpy.executors.ExternalShutdownException):
        rclpy.spin(node)


if __name__ == "__main__":
    main()
