"""The publishers or subscriptions of a topic that may have several types."""

import threading
from collections.abc import Callable
from functools import partial
from typing import Generic, TypeVar

from rclpy.publisher import Publisher
from rclpy.subscription import Subscription

from dock_gateway.ros.bridge import Bridge
from dock_gateway.ros.listening_node import ListeningNode
from robot_io.velocity import CLASSES

EndpointT = TypeVar("EndpointT", Publisher, Subscription)


class Endpoints(Generic[EndpointT]):
    """The publishers or the subscriptions of a topic by type, each on the bridge or on a branch.

    Args:
        bridge: The bridge. All but `add` is called on its thread.
        make: Makes one of a type on a node.
        destroy: Destroys one.
    """

    def __init__(
        self,
        bridge: Bridge,
        make: Callable[[ListeningNode, type], EndpointT],
        destroy: Callable[[ListeningNode, EndpointT], object],
    ) -> None:
        self.of: dict[str, tuple[Bridge, EndpointT]] = {}  # replaced, never changed: the loop publishes
        self._bridge = bridge
        self._make = make
        self._destroy = destroy
        self._closed = False
        self._changing = threading.Lock()

    def add(self, bridge: Bridge, name: str) -> None:
        """Add one of a type, on a bridge or a branch, on whose thread this is called."""
        with self._changing:
            if not self._closed and name not in self.of:
                self.of = {**self.of, name: (bridge, self._make(bridge.node, CLASSES[name]))}

    def drop(self, unwanted: Callable[[str, Bridge], bool] = lambda *_: True) -> None:
        """Destroy all, or those of unwanted types."""
        with self._changing:
            before = self.of
            self.of = {name: both for name, both in before.items() if not unwanted(name, both[0])}
        for name in before.keys() - self.of.keys():
            bridge, endpoint = before[name]
            if bridge is self._bridge:
                self._destroy(bridge.node, endpoint)
            else:
                bridge.to_ros(partial(self._destroy, bridge.node, endpoint))

    def close(self) -> None:
        """Destroy all, and take no more."""
        self._closed = True
        self.drop()
