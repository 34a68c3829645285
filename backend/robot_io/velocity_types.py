"""The types of a robot's velocity topic: a base takes one and ignores the other. Pure."""

from collections.abc import Set as AbstractSet

PLAIN, STAMPED = TYPES = ("geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped")


def fitting_types(subscribed: AbstractSet[str], otherwise: AbstractSet[str]) -> frozenset[str]:
    """Return the types to publish: all that are subscribed to.

    Args:
        subscribed: The types that bases subscribe to, of any kind.
        otherwise: The types to publish while no base subscribes to a velocity; `PLAIN` if it is empty.
    """
    return frozenset(subscribed & set(TYPES) or otherwise or {PLAIN})
