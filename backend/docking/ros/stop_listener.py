"""Listens for stops of the robot: on `stop_latched`, and on the topics of emergency stops."""

from collections.abc import Callable, Sequence
from typing import Any

from rclpy.callback_groups import CallbackGroup, ReentrantCallbackGroup
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.qos_overriding_options import QoSOverridingOptions
from rclpy.subscription import Subscription
from rclpy.waitable import NumberOfEntities, Waitable
from std_msgs.msg import Bool

from docking.core.stop_votes import StopVotes
from docking.ros.endpoint import node_name
from docking.ros.qos import latched, volatile
from docking.ros.taking import take_bool

TOPIC = "stop_latched"
DEPTH = 50
# A subscription to what was said before hears no publisher that does not keep it, so each topic has two.
QUALITIES = (latched(DEPTH), volatile(DEPTH))


class _Hidden(CallbackGroup):  # type: ignore[misc] # rclpy has no types
    """Keeps the executor from taking messages, as `_Ear` does that."""

    def can_execute(self, entity: object) -> bool:
        return False

    def beginning_execution(self, entity: object) -> bool:
        return False

    def ending_execution(self, entity: object) -> None:
        """Nothing ends."""


class _Ear(Waitable):  # type: ignore[misc] # rclpy has no types
    """Waits for the messages of one subscription, and hands them on with their publisher."""

    def __init__(self, subscription: Subscription, take: Callable[[], None]) -> None:
        super().__init__(ReentrantCallbackGroup())
        self.subscription = subscription
        self._take = take
        self._index = -1

    def get_num_entities(self) -> NumberOfEntities:
        return NumberOfEntities(1)

    def add_to_wait_set(self, wait_set: Any) -> None:
        self._index = wait_set.add_subscription(self.subscription.handle)

    def is_ready(self, wait_set: Any) -> bool:
        return bool(wait_set.is_ready("subscription", self._index))

    def take_data(self) -> None:
        self._take()

    async def execute(self, taken_data: None) -> None:
        """All is done."""


class StopListener:
    """Whether a stop holds. All calls must come from the thread that spins the node.

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
        self._ears: dict[str, list[_Ear]] = {}
        self._subscribe(TOPIC)

    def listen_to(self, topics: Sequence[str]) -> None:
        """Listen to these topics, too, and to no others any longer; what was said on those counts no more."""
        wanted = dict.fromkeys((TOPIC, *topics))
        for topic in self._ears.keys() - wanted.keys():
            del self._votes[topic]
            for ear in self._ears.pop(topic):
                self._node.remove_waitable(ear)
                self._node.destroy_subscription(ear.subscription)
        for topic in wanted:
            if topic not in self._ears:
                self._subscribe(topic)
        self._update()

    def _subscribe(self, topic: str) -> None:
        self._votes[topic] = StopVotes()
        ears: list[_Ear] = []
        self._ears[topic] = ears
        try:
            for quality in QUALITIES:
                ears.append(self._listen(topic, quality))  # noqa: PERF401 - those before a failure are kept, too
        except Exception as error:  # noqa: BLE001 - rclpy raises many kinds: for a type, a name, a quality of service
            self._node.get_logger().error(f"Cannot subscribe to {topic}, which counts as a stop: {error}")

    def _listen(self, topic: str, quality: QoSProfile) -> _Ear:
        kept = quality.durability is DurabilityPolicy.TRANSIENT_LOCAL
        overriding = QoSOverridingOptions.with_default_policies(entity_id="latched" if kept else "volatile")
        subscription = self._node.create_subscription(
            Bool, topic, _ignore, quality, callback_group=_Hidden(), qos_overriding_options=overriding
        )
        ear = _Ear(subscription, lambda: self._hear(topic, subscription))
        self._node.add_waitable(ear)
        return ear

    def _hear(self, topic: str, subscription: Subscription) -> None:
        votes = self._votes.get(topic)
        while votes is not None and (taken := take_bool(subscription)) is not None:
            votes.hear(taken.publisher, taken.number, latched=taken.data)
            if votes.unknown:
                self._look(topic)
            self._update()

    def look(self) -> None:
        """See who is there; call it once a second."""
        for topic, ears in self._ears.items():
            if ears:
                self._look(topic)
        self._update()

    def _look(self, topic: str) -> None:
        publishers = self._node.get_publishers_info_by_topic(topic)
        listeners = self._node.get_subscriptions_info_by_topic(topic)
        # As gateways do: they keep what they said for who comes later.
        keeping = {
            bytes(info.endpoint_gid)
            for info in publishers
            if topic == TOPIC and info.qos_profile.durability is DurabilityPolicy.TRANSIENT_LOCAL
        }
        self._votes[topic].look(
            {bytes(info.endpoint_gid): node_name(info) for info in publishers},
            {name for info in listeners if (name := node_name(info))},
            keeping,
        )

    def _update(self) -> None:
        deaf = any(len(ears) < len(QUALITIES) for ears in self._ears.values())
        held = deaf or any(votes.held for votes in self._votes.values())
        if held != self.held:
            self.held = held
            self._on_change()


def _ignore(_: Bool) -> None:
    """Take nothing: `_Ear` does."""
