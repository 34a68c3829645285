"""Namespaces of robots: reading and normalizing them."""

import re

from dock_gateway.core.errors import FieldError, InvalidField
from dock_gateway.setting_types import LONGEST_NAME, ROS_TOKEN

# As the target of a stop or a release: every robot that the gateway serves, whatever its namespace.
ALL_ROBOTS = "/"
NAMESPACE = re.compile(f"/(?:{ROS_TOKEN.pattern}(?:/{ROS_TOKEN.pattern})*/?)?")


def is_namespace(text: str) -> bool:
    """Return whether a text is a ROS namespace, not longer than one can be."""
    return len(text) <= LONGEST_NAME and NAMESPACE.fullmatch(text) is not None


def normalize_namespace(namespace: str) -> str:
    """Normalize a namespace: `robot1`, `/robot1` and `/robot1/` become `/robot1`; an empty one becomes `/`."""
    return f"/{namespace.strip('/')}"


def read_namespace(namespace: str) -> str:
    """Validate and normalize a namespace from a client, by the parameter `robot`.

    Raises:
        InvalidField: It is not a ROS namespace, or longer than one can be.
    """
    if not is_namespace(namespace):
        detail = f"got {len(namespace)} characters" if len(namespace) > LONGEST_NAME else f"got {namespace!r:.60}"
        raise InvalidField([FieldError("robot", "a ROS namespace such as /robot1", detail, "query")])
    return normalize_namespace(namespace)
