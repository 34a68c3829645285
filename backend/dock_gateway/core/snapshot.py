"""The ROS graph as a node that only listens sees it in a few seconds. Plain data."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class GraphSnapshot:
    """The ROS graph, without gateways.

    Attributes:
        seconds: How long it took.
        nodes: The number of nodes.
        actions: The types of the actions that have a server, by name.
        servers: The number of servers of each action.
        batteries: The last message of each topic on which a battery is published, as JSON; None if none came. An
            infinity is a text, such as `inf`.
    """

    seconds: float
    nodes: int = 0
    actions: Mapping[str, list[str]] = field(default_factory=dict)
    servers: Mapping[str, int] = field(default_factory=dict)
    batteries: Mapping[str, Mapping[str, Any] | None] = field(default_factory=dict)
