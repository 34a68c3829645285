"""A base that takes one type of velocity, and its driver, who drives on after each stop, in a process of their own.

Within one process, Fast DDS takes a shorter way, on which one of a few hundred new publishers is never heard of.
"""

import contextlib
import sys

import rclpy
from geometry_msgs.msg import Twist, TwistStamped, Vector3
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node

ZERO = Twist()


def main() -> None:
    name, speed = sys.argv[1], float(sys.argv[2])
    stamped = name == "stamped"
    kind = TwistStamped if stamped else Twist
    rclpy.init()
    base, driver = Node(name), Node(f"{name}_driver")  # a node that publishes velocity would be no base
    forward = Twist(linear=Vector3(x=speed))
    publisher = driver.create_publisher(kind, "cmd_vel", 10)

    def obey(message: Twist | TwistStamped) -> None:
        if (message.twist if stamped else message) != ZERO:
            return
        print("stopped" if not stamped or message.header.stamp.sec > 0 else "no stamp", flush=True)
        publisher.publish(TwistStamped(twist=forward) if stamped else forward)

    base.create_subscription(kind, "cmd_vel", obey, 10)
    executor = SingleThreadedExecutor()
    for node in (base, driver):
        executor.add_node(node)
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        executor.spin()


if __name__ == "__main__":
    main()
