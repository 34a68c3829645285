"""Namespaces: what lies in one. Plain text, as ROS names are."""


def prefix_of(namespace: str) -> str:
    """What the names in a namespace begin with."""
    return f"{namespace.rstrip('/')}/"


def is_under(name: str, namespace: str) -> bool:
    """Whether a namespace or an action is a namespace, or in it."""
    return prefix_of(name).startswith(prefix_of(namespace))
