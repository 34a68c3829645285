"""A message of a relayed topic."""

from collections.abc import Callable
from typing import Any, TypeVar

from dock_gateway.graph.subscription import OFFER, Offer
from dock_gateway.ros.raw_port import Arrival, EchoType

Made = TypeVar("Made")


class Received:
    """A message on a topic, for all who read the topic.

    Args:
        kind: The type of the topic.
        arrival: The serialized message.
        offer: What the publishers of the topic offer.

    Attributes:
        topic: Absolute name of the topic.
        kind: Its type, which decodes `data`.
        data: The serialized message (CDR).
        source_ns: When it was sent, in ns since 1970; 0 if unknown.
        received_ns: When it came, in ns since 1970.
        reliable: Whether a publisher of the topic sends again what was lost.
        kept: Number of messages that the publishers keep for later subscribers.
    """

    def __init__(self, topic: str, kind: EchoType, arrival: Arrival, offer: Offer = OFFER) -> None:
        self.topic = topic
        self.kind = kind
        self.reliable, self.kept = offer
        self.data, self.source_ns, self.received_ns = arrival
        self._made: dict[object, Any] = {}

    @property
    def size(self) -> int:
        """Number of bytes in ROS."""
        return len(self.data)

    def once(self, make: "Callable[[Received], Made]") -> "Made":
        """Return what `make` makes of this message; it is made once for all readers."""
        if make not in self._made:
            self._made[make] = make(self)
        made: Made = self._made[make]
        return made
