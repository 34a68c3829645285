"""Qualities of service that several nodes ask for."""

from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy


def volatile(depth: int) -> QoSProfile:
    """Best effort and volatile, which matches every publisher.

    Args:
        depth: How many messages are kept.
    """
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=depth,
        reliability=ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.VOLATILE,
    )


def latched(depth: int) -> QoSProfile:
    """Reliable and transient local: who comes later gets the last messages, too.

    Args:
        depth: How many messages are kept.
    """
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=depth,
        reliability=ReliabilityPolicy.RELIABLE,
        durability=DurabilityPolicy.TRANSIENT_LOCAL,
    )


LATEST = volatile(1)
"""For sensors: an older message is of no use."""
LATCHED = latched(1)
LISTEN = volatile(50)
"""For messages that must not be lost."""
TALK = QoSProfile(depth=10)
"""ROS's default."""
