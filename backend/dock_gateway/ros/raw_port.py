"""Subscriptions to any topic as bytes: every message is counted, but only displayed ones are decoded."""

import time
from collections import deque
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message

from dock_gateway.core.errors import Conflict
from dock_gateway.core.goal import Json
from dock_gateway.ros.bridge import Bridge
from dock_gateway.ros.listener import Handler
from dock_gateway.ros.messages.abbreviate import abbreviate
from dock_gateway.ros.messages.codec import codec
from dock_gateway.ros.messages.interfaces import load_message
from dock_gateway.ros.messages.types import MessageClass
from robot_io.rclpy_private import RCLError

# Messages queued for the listener: at 3,000 a second, enough for a delay of 60 ms.
DEPTH = 200
# The same for messages of a megabyte and more: only the newest counts.
LARGE_DEPTH = 3
LARGE = frozenset(
    {
        "sensor_msgs/msg/Image",
        "sensor_msgs/msg/CompressedImage",
        "sensor_msgs/msg/PointCloud2",
        "nav_msgs/msg/OccupancyGrid",
    }
)


class Heard(NamedTuple):
    """Counts of received messages and bytes of a topic, and the newest message with its source timestamp."""

    messages: int = 0
    size: int = 0
    newest: bytes | None = None
    stamp_ns: int = 0


class Arrival(NamedTuple):
    """A serialized message (CDR), when it was sent, and when it came (ns since 1970)."""

    data: bytes
    source_ns: int
    received_ns: int


class EchoType:
    """A message type by its name, such as `sensor_msgs/msg/BatteryState`. The constructor imports its package.

    Attributes:
        name: The name.
        hint: What to do if its messages cannot be read; None if they can.
        message_class: The class to subscribe with; None if its messages cannot be read.
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
        """Whether its messages can be read."""
        return self.message_class is not None

    def read(self, message: bytes) -> "DecodedMessage":
        """Decode a message to abbreviated JSON; thread-safe.

        Raises:
            Exception: The bytes are not such a message.
        """
        began = time.thread_time()
        decoded = self.decode(message)
        lengths = abbreviate(decoded)
        return DecodedMessage(codec(self.message_class).encode(decoded), lengths, time.thread_time() - began)

    def decode(self, message: bytes) -> Any:
        """Return a message as an instance of `message_class`; thread-safe.

        Raises:
            Exception: The bytes are not such a message.
        """
        return deserialize_message(message, self.message_class)


@cache
def echo_type(name: str) -> EchoType:
    """Return a type, made once: in a process that only decodes messages, too."""
    return EchoType(name)


def read_message(name: str, message: bytes) -> "DecodedMessage":
    """Decode a message of the type of this name to abbreviated JSON.

    Raises:
        Exception: The bytes are not such a message.
    """
    return echo_type(name).read(message)


class DecodedMessage(NamedTuple):
    """A decoded message, the original lengths of its truncated fields by dotted path, and seconds of CPU time."""

    message: Json
    lengths: dict[str, int]
    took: float


class EchoPort:
    """A subscription to a topic, created and closed on the ROS thread.

    Args:
        bridge: The bridge to the ROS thread.
        topic: Absolute name.
        kind: Type of the topic.
        reliable: Whether lost messages are requested again.
        latched: Whether earlier messages are requested.
        on_news: Called on the loop at the first message after each `tell_next`.
        heard: Counts and newest message of an earlier port.
        keep: Number of messages that are kept until they are taken, besides the newest one.

    Raises:
        Conflict: `topic_in_use`: the gateway itself uses the topic with another type.
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
        keep: int = 0,
    ) -> None:
        self._depth = depth = LARGE_DEPTH if kind.name in LARGE else DEPTH
        self._kept: deque[Arrival] = deque(maxlen=min(keep, depth))
        self.heard = heard._replace(newest=None)
        self._bridge = bridge
        self._on_news = on_news
        self._waited_for = True
        profile = QoSProfile(
            depth=depth,
            reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
            durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
        )
        try:
            self._subscription = kind.message_class and bridge.node.subscribe(
                kind.message_class, topic, Handler(self._hear), profile, raw=True
            )
        except RCLError as error:  # one participant has one type for each topic
            detail = f"{topic} is read as {kind.name}, and the gateway itself uses it with another type"
            raise Conflict(detail, code="topic_in_use") from error

    def close(self) -> None:
        """Leave the topic."""
        if self._subscription is not None:
            self._bridge.node.destroy_subscription(self._subscription)

    def keep(self, keep: int) -> None:
        """Keep another number of messages until they are taken. Those that are kept already are forgotten."""
        if self._kept.maxlen != (most := min(keep, self._depth)):
            self._kept = deque(maxlen=most)

    def tell_next(self) -> None:
        """Call `on_news` once, at the next message."""
        self._waited_for = True

    def take(self) -> list[Arrival]:
        """Return the messages since the last call, oldest first. If there were more than `keep`, the newest ones."""
        taken = []
        while self._kept:
            taken.append(self._kept.popleft())
        return taken

    def _hear(self, message: bytes, info: dict[str, Any]) -> None:
        before = self.heard
        source_ns = info["source_timestamp"]
        self.heard = Heard(before.messages + 1, before.size + len(message), message, source_ns)
        self._kept.append(Arrival(message, source_ns, time.time_ns()))
        if self._waited_for:
            self._waited_for = False
            self._bridge.to_loop(self._on_news)
