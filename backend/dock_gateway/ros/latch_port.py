"""The stop latch of a robot, `stop_latched`, and those who may stop it, such as emergency stops.

Ports are created and closed on the ROS thread; their other methods are called on the loop. The latch is published from
the loop itself, because a stop must not wait for the ROS thread (docs/decisions.md).
"""

import threading
import time
from collections.abc import Callable, Iterable

from rclpy.publisher import Publisher
from rclpy.subscription import Subscription
from std_msgs.msg import Bool

from dock_gateway.core.graph import Endpoint
from dock_gateway.ros.graph import read_topic
from dock_gateway.ros.listener import Handler
from dock_gateway.ros.typed_topics import GatewayEndpoints, TypedTopics
from robot_io.qos import LATCHED, LISTEN
from robot_io.rclpy_private import Taken, take_bool

# Nanoseconds after the start of a publish call within which a message's stamp may be our own.
OWN_WITHIN = 1_000_000_000
# Nanoseconds that our own message may arrive late, on a busy machine. Mistaken for another gateway's, it might release
# a stop.
OWN_REMEMBERED = 20_000_000_000

# A publisher: its topic and the id of the endpoint.
PublisherKey = tuple[str, bytes]


class LatchPort:
    """`std_msgs/Bool` on `stop_latched`: whether a stop is latched for the robot.

    Gateways keep what they said for late subscribers (transient local), and agree on what the last of them said.
    Each publisher on it that keeps nothing, and each on the other topics, such as an emergency stop, holds the robot
    until it releases it itself.

    On a topic of another type nothing is published or heard, which `publish` reports; what was to be published last is
    published as soon as its type fits.

    Args:
        topics: Joins the topics.
        topic: Absolute name.
        others: Absolute names of topics on which only others speak.
        on_latch: Called on the loop with the value from other gateways, and when it arrived, on the monotonic clock.
        on_hold: Called on the loop with the node that holds the robot, again when its name becomes known or another one
            lets go, or None when none does any longer.
    """

    def __init__(
        self,
        topics: TypedTopics,
        topic: str,
        others: Iterable[str],
        *,
        on_latch: Callable[[bool, float], None],
        on_hold: Callable[[str | None], None],
    ) -> None:
        self._bridge = topics.bridge
        self._on_latch = on_latch
        self._on_hold = on_hold
        self._inbox = self._bridge.inbox()
        self._lock = threading.Lock()  # guards what follows, which is written on the listener's and the ROS thread
        self._numbers: dict[PublisherKey, int] = {}  # of the last message of each publisher that is no gateway
        self._nodes: dict[PublisherKey, str] = {}  # where that is known
        self._holding: frozenset[PublisherKey] = frozenset()  # those that say true
        self._gateways: set[bytes] = set()
        self._topic = topic
        self._own: tuple[tuple[int, int], ...] = ()  # our publish calls; read on the listener's thread
        self._latched: bool | None = None  # what we published last; None: nothing, or it was withdrawn
        self._joined = topics.join(
            topic,
            Bool,
            topic,
            GatewayEndpoints(
                ((self._handler(topic, latched=True), LATCHED), (self._handler(topic), LISTEN)),
                publish=LATCHED,
                on_open=self._repeat,
            ),
        )
        self._topics = [self._joined]
        for other in dict.fromkeys(others):
            if other != topic:
                hear = self._handler(other)
                self._topics.append(
                    topics.join(other, Bool, topic, GatewayEndpoints(((hear, LATCHED), (hear, LISTEN))))
                )

    def _repeat(self) -> None:
        if (latched := self._latched) is not None:
            self._publish(self._joined.publisher, latched=latched)

    def _handler(self, topic: str, *, latched: bool = False) -> Handler:
        """Return what handles the messages of a topic: of those who keep them, if `latched`."""

        def hear(taken: Taken, _: None) -> None:
            if latched:
                self._hear_gateway(taken)
            else:
                self._hear_other(topic, taken)

        def take(subscription: Subscription) -> bool:
            if (taken := take_bool(subscription)) is not None:
                handler(taken, None)
            return taken is not None

        handler = Handler(hear, take=take)
        return handler

    def _hear_gateway(self, taken: Taken) -> None:
        self._gateways.add(taken.publisher)
        if not self._is_own(taken):
            self._inbox.put(self._on_latch, taken.data, time.monotonic())
        self._hold((self._topic, taken.publisher), latched=False)  # it was not known for a gateway before

    def _hear_other(self, topic: str, taken: Taken) -> None:
        publisher = topic, taken.publisher
        if topic == self._topic and (taken.publisher in self._gateways or self._is_own(taken)):
            return  # heard by the other subscription
        named = False
        if publisher not in self._nodes:
            endpoint = self._endpoint(publisher)
            if endpoint is not None and topic == self._topic and endpoint.qos.durability == "transient_local":
                return
            if endpoint is not None and endpoint.node is not None:
                self._nodes[publisher] = endpoint.node
                named = True  # ROS may know the name later than the first message
        if taken.number > self._numbers.get(publisher, -1):
            self._numbers[publisher] = taken.number
            self._hold(publisher, latched=taken.data, named=named)

    def _is_own(self, taken: Taken) -> bool:
        return any(first <= taken.stamp_ns <= last for first, last in reversed(self._own))

    def _hold(self, publisher: PublisherKey, *, latched: bool, named: bool = False) -> None:
        """Note what a publisher says, which also replaces what one of the same node said that has left.

        Args:
            publisher: The publisher.
            latched: Whether it wants the robot to stand.
            named: Whether the name of its node has just become known.
        """
        node = self._nodes.get(publisher)
        with self._lock:
            before = self._holding
            gone = {
                other
                for other in before - {publisher}
                if node is not None and self._nodes.get(other) == node and self._endpoint(other) is None
            }
            self._holding = (before - gone - {publisher}) | ({publisher} if latched else frozenset())
            if before - self._holding or (latched and (named or not before)):
                holder = publisher if latched else min(self._holding, default=None)
                self._inbox.put(self._on_hold, None if holder is None else self._name(holder))

    def _endpoint(self, publisher: PublisherKey) -> Endpoint | None:
        """Return a publisher as the graph has it; None if it has left."""
        topic, gid = publisher
        return next((there for there in read_topic(self._bridge.node, topic).publishers if there.gid == gid), None)

    def _name(self, publisher: PublisherKey) -> str:
        return self._nodes.get(publisher, f"a node on {publisher[0]}")

    def held_by(self) -> str | None:
        """Return a node that holds the robot and is there, if one does."""
        return next((self._name(publisher) for publisher in self._holding if self._endpoint(publisher)), None)

    def let_go(self) -> None:
        """Forget those who held the robot and have left."""
        with self._lock:
            self._holding = frozenset(publisher for publisher in self._holding if self._endpoint(publisher))

    def close(self) -> None:
        """Leave the topics."""
        for topic in self._topics:
            topic.close()

    def publish(self, *, latched: bool) -> None:
        """Publish the latch immediately; late subscribers get the last message.

        Raises:
            RuntimeError: The topic is of another type on the ROS graph.
            Exception: ROS does not take the message.
        """
        self._latched = latched
        self._publish(self._joined.publisher, latched=latched)

    def _publish(self, publisher: Publisher | None, *, latched: bool) -> None:
        if publisher is None:
            raise RuntimeError(f"{self._topic} is of another type on the ROS graph than std_msgs/msg/Bool")
        first = time.time_ns()
        before = tuple(own for own in self._own if own[1] > first - OWN_REMEMBERED)
        self._own = (*before, (first, first + OWN_WITHIN))  # it may arrive before the end is known
        try:
            publisher.publish(Bool(data=latched))
        finally:
            self._own = (*before, (first, time.time_ns()))

    async def withdraw(self) -> None:
        """Replace the publisher, so that late subscribers no longer get our last message.

        Raises:
            Unavailable: The ROS thread is down.
        """

        def withdraw() -> None:
            self._latched = None
            self._joined.replace_publisher()

        await self._bridge.call(withdraw, even_late=True)
