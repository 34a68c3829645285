"""Listens for stops of the robot: on `stop_latched`, and on the topics of emergency stops."""

from collections.abc import Callable, Sequence

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.qos_overriding_options import QoSOverridingOptions
from rclpy.subscription import Subscription
from std_msgs.msg import Bool

from robot_io.endpoints import node_name
from robot_io.qos import LISTEN, latched
from robot_io.rclpy_private import NotForExecutors, SubscriptionWaitable, take_bool
from robot_io.stop_votes import StopVotes

TOPIC = "stop_latched"
# A subscription to what was said before hears no publisher that does not keep it, so each topic has two.
QUALITIES = (latched(LISTEN.depth), LISTEN)


class StopListener:
    """Tells whether a stop holds. All calls must come from the thread that spins the node.

    A topic that cannot be subscribed to counts as a stop, because a stop on it would not be heard.

    Attributes:
        held: Whether one does.
    """

    def __init__(self, node: Node, on_change: Callable[[], None]) -> None:
        """Listen to `stop_latched`.

        Args:
            node: The node that subscribes.
            on_change: Called when `held` has changed.
        """
        self.held = False
        self._node = node
        self._on_change = on_change
        self._votes: dict[str, StopVotes] = {}
        self._subscriptions: dict[str, list[SubscriptionWaitable]] = {}
        self._subscribe(TOPIC)

    def listen_to(self, topics: Sequence[str]) -> None:
        """Listen to these topics, too, and to no others any longer; what was said on those counts no more."""
        wanted = dict.fromkeys((TOPIC, *topics))
        for topic in self._subscriptions.keys() - wanted.keys():
            del self._votes[topic]
            for waitable in self._subscriptions.pop(topic):
                self._node.remove_waitable(waitable)
                self._node.destroy_subscription(waitable.subscription)
        for topic in wanted:
            if topic not in self._subscriptions:
                self._subscribe(topic)
        self._update()

    def _subscribe(self, topic: str) -> None:
        self._votes[topic] = StopVotes()
        subscriptions: list[SubscriptionWaitable] = []
        self._subscriptions[topic] = subscriptions
        try:
            for quality in QUALITIES:
                subscriptions.append(self._listen(topic, quality))  # noqa: PERF401 - those before a failure are kept, too
        except Exception as error:  # noqa: BLE001 - rclpy raises many kinds: for a type, a name, a quality of service
            self._node.get_logger().error(f"Cannot subscribe to {topic}, which counts as a stop: {error}")

    def _listen(self, topic: str, quality: QoSProfile) -> SubscriptionWaitable:
        kept = quality.durability is DurabilityPolicy.TRANSIENT_LOCAL
        overriding = QoSOverridingOptions.with_default_policies(entity_id="latched" if kept else "volatile")
        subscription = self._node.create_subscription(
            Bool, topic, _ignore, quality, callback_group=NotForExecutors(), qos_overriding_options=overriding
        )
        waitable = SubscriptionWaitable(subscription, lambda: self._hear(topic, subscription))
        self._node.add_waitable(waitable)
        return waitable

    def _hear(self, topic: str, subscription: Subscription) -> None:
        votes = self._votes.get(topic)
        while votes is not None and (taken := take_bool(subscription)) is not None:
            votes.hear(taken.publisher, taken.number, latched=taken.data)
            if votes.unknown:
                self._scan(topic)
            self._update()

    def scan(self) -> None:
        """Update which publishers and subscribers there are; call it once a second."""
        for topic, subscriptions in self._subscriptions.items():
            if subscriptions:
                self._scan(topic)
        self._update()

    def _scan(self, topic: str) -> None:
        publishers = self._node.get_publishers_info_by_topic(topic)
        listeners = self._node.get_subscriptions_info_by_topic(topic)
        # As gateways do: they keep what they said for who comes later.
        keeping = {
            bytes(info.endpoint_gid)
            for info in publishers
            if topic == TOPIC and info.qos_profile.durability is DurabilityPolicy.TRANSIENT_LOCAL
        }
        self._votes[topic].update_graph(
            {bytes(info.endpoint_gid): node_name(info) for info in publishers},
            {name for info in listeners if (name := node_name(info))},
            keeping,
        )

    def _update(self) -> None:
        unheard = any(len(subscriptions) < len(QUALITIES) for subscriptions in self._subscriptions.values())
        held = unheard or any(votes.held for votes in self._votes.values())
        if held != self.held:
            self.held = held
            self._on_change()


def _ignore(_: Bool) -> None:
    """Take nothing: `SubscriptionWaitable` does."""
