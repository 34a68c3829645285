"""Namespaces: what lies in one. Plain text, as ROS names are."""

from collections.abc import Iterator


def prefix_of(namespace: str) -> str:
    """What the names in a namespace begin with."""
    return f"{namespace.rstrip('/')}/"


def is_under(name: str, namespace: str) -> bool:
    """Whether a namespace or an action is a namespace, or in it."""
    return prefix_of(name).startswith(prefix_of(namespace))


def lineage(name: str) -> Iterator[str]:
    """The namespaces that a name is in, from the root on, and the name itself: `/`, `/fleet`, `/fleet/robot1`."""
    yield "/"
    for end, character in enumerate(name[1:], 1):
        if character == "/":
            yield name[:end]
    if name != "/":
        yield name
