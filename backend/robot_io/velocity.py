"""Velocity messages, geometry_msgs/Twist and geometry_msgs/TwistStamped."""

from geometry_msgs.msg import Twist, TwistStamped
from rclpy.node import Node

from robot_io.velocity_types import PLAIN, STAMPED

CLASSES: dict[str, type] = {PLAIN: Twist, STAMPED: TwistStamped}


def velocity_message(name: str, twist: Twist, node: Node, frame: str = "") -> Twist | TwistStamped:
    """Return a velocity as a message of a type.

    Args:
        name: The type, one of `CLASSES`.
        twist: The velocity.
        node: Its clock stamps a stamped message.
        frame: The frame of a stamped message.
    """
    if name == PLAIN:
        return twist
    message = TwistStamped(twist=twist)
    message.header.stamp = node.get_clock().now().to_msg()
    message.header.frame_id = frame
    return message
