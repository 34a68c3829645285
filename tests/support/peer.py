"""A ROS node that is driven, or that drives whoever it reaches: `python -m tests.support.peer NAME [SPEED]`.

With a speed it publishes that on /cmd_vel, ten times a second. Without, it prints `driven at SPEED` for each message
there. Both print `finds NODE` once for each node that they find.
"""

import contextlib
import sys

import rclpy
from geometry_msgs.msg import Twist
from rclpy.executors import ExternalShutdownException


def main() -> None:
    name, *speeds = sys.argv[1:]
    rclpy.init()
    node = rclpy.create_node(name)
    found: set[str] = set()

    def look() -> None:
        new = set(node.get_node_names()) - found
        found.update(new)
        for other in sorted(new):
            print("finds", other, flush=True)

    node.create_timer(0.1, look)
    if speeds:
        message = Twist()
        message.linear.x = float(speeds[0])
        publisher = node.create_publisher(Twist, "/cmd_vel", 10)
        node.create_timer(0.1, lambda: publisher.publish(message))
    else:
        node.create_subscription(Twist, "/cmd_vel", lambda heard: print("driven at", heard.linear.x, flush=True), 10)
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(node)


if __name__ == "__main__":
    main()
