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


def twist_of(message: Twist | TwistStamped) -> Twist:
    """Return the velocity in a message of either type."""
    return message.twist if isinstance(message, TwistStamped) else message


def is_motion(message: Twist | TwistStamped) -> bool:
    """Return whether a velocity is not zero; one that is no number counts as a motion."""
    twist = twist_of(message)
    linear, angular = twist.linear, twist.angular
    return any(value != 0.0 for value in (linear.x, linear.y, linear.z, angular.x, angular.y, angular.z))
