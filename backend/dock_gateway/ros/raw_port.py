"""Any topic, heard as bytes: every message is counted, and only those that somebody gets to see are decoded."""

import time
from collections.abc import Callable
from typing import Any, NamedTuple

from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message

from dock_gateway.core.goal import Json
from dock_gateway.ros.bridge import Bridge, guard
from dock_gateway.ros.messages.abbreviate import abbreviate
from dock_gateway.ros.messages.codec import codec
from dock_gateway.ros.messages.interfaces import load_message
from dock_gateway.ros.messages.types import MessageClass

# So many messages wait for the listener: at 3,000 a second it may be kept from them for 60 ms.
DEPTH = 200


class Heard(NamedTuple):
    """All that was heard of a topic: how many messages, how many bytes, and the newest with its source timestamp."""

    messages: int = 0
    size: int = 0
    newest: bytes | None = None
    stamp_ns: int = 0


class EchoType:
    """A type of messages by its name, such as `sensor_msgs/msg/BatteryState`; making one imports its package.

    Attributes:
        name: The name.
        hint: What to do where its messages cannot be read; None where they can.
        message_class: What to subscribe with; None where its package is missing.
    """

    def __init__(self, name: str) -> None:
        self.name = name
        self.hint: str | None = None
        self.message_class: MessageClass | None = None
        try:
            self.message_class = load_message(name)
            codec(self.message_class)
        except (ImportError, TypeError) as error:
            self.message_class, self.hint = None, str(error)

    @property
    def installed(self) -> bool:
        """Whether messages can be read."""
        return self.message_class is not None

    def read(self, message: bytes) -> "Reading":
        """A message as JSON, cut down; for any thread.

        Raises:
            Exception: Whatever comes of bytes that are no such message.
        """
        began = time.thread_time()
        decoded = deserialize_message(message, self.message_class)
        lengths = abbreviate(decoded)
        return Reading(codec(self.message_class).encode(decoded), lengths, time.thread_time() - began)


class Reading(NamedTuple):
    """A message that was read; how long each of its fields was that has been cut, by dotted path; seconds it took."""

    message: Json
    lengths: dict[str, int]
    took: float


class EchoPort:
    """Hears a topic. It is made and closed on the ROS thread.

    Args:
        bridge: Where the ROS thread is.
        topic: Absolute name.
        kind: Its type.
        reliable: Whether to ask for lost messages again.
        latched: Whether to ask for what was published before.
        on_news: Called on the loop with the first message after each `tell_next`.
        heard: What was heard before, by another port.
    """

    def __init__(
        self,
        bridge: Bridge,
        topic: str,
        kind: EchoType,
        *,
        reliable: bool,
        latched: bool,
        on_news: Callable[[], None],
        heard: Heard,
    ) -> None:
        self.heard = heard._replace(newest=None)
        self._bridge = bridge
        self._on_news = on_news
        self._waited_for = True
        profile = QoSProfile(
            depth=DEPTH,
            reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
            durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
        )
        self._subscription = kind.message_class and bridge.node.create_subscription(
            kind.message_class, topic, guard(self._hear), profile, raw=True
        )

    def close(self) -> None:
        """Leave the topic."""
        if self._subscription is not None:
            self._bridge.node.destroy_subscription(self._subscription)

    def tell_next(self) -> None:
        """Call `on_news` once, as soon as there is another message."""
        self._waited_for = True

    def _hear(self, message: bytes, info: dict[str, Any]) -> None:
        before = self.heard
        self.heard = Heard(before.messages + 1, before.size + len(message), message, info["source_timestamp"])
        if self._waited_for:
            self._waited_for = False
            self._bridge.to_loop(self._on_news)
