"""The stop latch of a robot, `stop_latched`, and those who may stop it, such as emergency stops.

Ports are created and closed on the ROS thread; their other methods are called on the loop. The latch is published from
the loop itself, because a stop must not wait for the ROS thread (docs/decisions.md).
"""

import time
from collections.abc import Callable, Iterable

from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription
from std_msgs.msg import Bool

from dock_gateway.ros.bridge import Bridge, guard
from dock_gateway.ros.graph import read_topic
from dock_gateway.ros.qos import LATCHED, LISTEN
from dock_gateway.ros.taking import Taken, take_bool

# Nanoseconds after the start of a publish call within which a message's stamp may be our own.
OWN_WITHIN = 1_000_000_000
# Nanoseconds that our own message may arrive late, on a busy machine. Mistaken for another gateway's, it might release
# a stop.
OWN_REMEMBERED = 20_000_000_000


class LatchPort:
    """`std_msgs/Bool` on `stop_latched`: whether a stop is latched for the robot.

    Of gateways, which listen to the topic, too, the last message counts. All others, such as emergency stops, hold the
    robot until they say otherwise, each for itself.

    Args:
        bridge: The bridge to the ROS thread.
        topic: Absolute name.
        others: Absolute names of topics on which only others speak.
        on_latch: Called on the loop with the value from other gateways, and when it arrived, on the monotonic clock.
        on_hold: Called on the loop with the node that holds the robot, or None when none does any longer.
    """

    def __init__(
        self,
        bridge: Bridge,
        topic: str,
        others: Iterable[str],
        *,
        on_latch: Callable[[bool, float], None],
        on_hold: Callable[[str | None], None],
    ) -> None:
        self._bridge = bridge
        self._on_latch = on_latch
        self._on_hold = on_hold
        self._inbox = bridge.inbox()
        self._heard: dict[tuple[str, bytes], int] = {}  # the number of the last message of each publisher
        self._holding: dict[tuple[str, bytes], str] = {}  # others that say true, with their nodes
        self._topic = topic
        self._own: tuple[tuple[int, int], ...] = ()  # our publish calls; read on the listener's thread
        self._publisher = self._make_publisher()
        self._subscriptions = [
            self._listen(name, quality) for name in (topic, *others) for quality in (LATCHED, LISTEN)
        ]

    def _listen(self, topic: str, quality: QoSProfile) -> Subscription:
        def take(subscription: Subscription) -> bool:
            taken = take_bool(subscription)
            if taken is not None:
                hear(taken, None)
            return taken is not None

        hear = guard(lambda taken, _: self._hear(topic, taken))
        hear.take = take  # type: ignore[attr-defined]
        return self._bridge.node.create_subscription(Bool, topic, hear, quality)

    def _hear(self, topic: str, taken: Taken) -> None:
        own = any(first <= taken.stamp_ns <= last for first, last in reversed(self._own))
        key = topic, taken.publisher
        if taken.number <= self._heard.get(key, -1):
            return  # the other subscription had it
        self._heard[key] = taken.number
        if own and topic == self._topic:
            return
        node, is_gateway = self._who(topic, taken.publisher)
        if is_gateway and topic == self._topic:
            self._holding.pop(key, None)  # its name was not known before
            self._inbox.put(self._on_latch, taken.data, time.monotonic())
            return
        before = bool(self._holding)
        self._holding = {other: name for other, name in self._holding.items() if not self._replaces(key, node, other)}
        if taken.data:
            self._holding[key] = node
        if bool(self._holding) != before:
            self._inbox.put(self._on_hold, next(iter(self._holding.values()), None))

    def _who(self, topic: str, publisher: bytes) -> tuple[str, bool]:
        """Return the node of a publisher, and whether it listens to the topic, too."""
        seen = read_topic(self._bridge.node, topic)
        node = next((endpoint.node for endpoint in seen.publishers if endpoint.gid == publisher), None)
        return node or "a node", node is not None and any(endpoint.node == node for endpoint in seen.subscribers)

    def _replaces(self, key: tuple[str, bytes], node: str, other: tuple[str, bytes]) -> bool:
        """Return whether a publisher speaks for itself, or for one of its node that is gone."""
        return key == other or (self._holding[other] == node and not self._is_there(*other))

    def _is_there(self, topic: str, publisher: bytes) -> bool:
        return any(endpoint.gid == publisher for endpoint in read_topic(self._bridge.node, topic).publishers)

    def held_by(self) -> str | None:
        """Return the node that holds the robot and is there; whoever has left no longer holds it."""
        holding = self._holding
        return next((node for (topic, publisher), node in holding.items() if self._is_there(topic, publisher)), None)

    def let_go(self) -> None:
        """Forget those who held the robot and have left."""
        self._bridge.to_ros(self._forget)

    def _forget(self) -> None:
        self._holding = {key: node for key, node in self._holding.items() if self._is_there(*key)}

    def _make_publisher(self) -> Publisher:
        return self._bridge.node.create_publisher(Bool, self._topic, LATCHED)

    def close(self) -> None:
        """Leave the topic."""
        for subscription in self._subscriptions:
            self._bridge.node.destroy_subscription(subscription)
        self._bridge.node.destroy_publisher(self._publisher)

    def publish(self, *, latched: bool) -> None:
        """Publish the latch immediately; late subscribers get the last message.

        Raises:
            Exception: ROS does not take the message.
        """
        first = time.time_ns()
        before = tuple(own for own in self._own if own[1] > first - OWN_REMEMBERED)
        self._own = (*before, (first, first + OWN_WITHIN))  # it may arrive before the end is known
        try:
            self._publisher.publish(Bool(data=latched))
        finally:
            self._own = (*before, (first, time.time_ns()))

    async def withdraw(self) -> None:
        """Replace the publisher, so that late subscribers no longer get our last message.

        Raises:
            Unavailable: The ROS thread is down.
        """

        def withdraw() -> None:
            # Create the new publisher first: the loop may publish at any time.
            old, self._publisher = self._publisher, self._make_publisher()
            self._bridge.node.destroy_publisher(old)

        await self._bridge.call(withdraw, even_late=True)
