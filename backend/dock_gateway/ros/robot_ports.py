"""The topics around an action: battery state in and out, velocity in and zero out, the stop latch, diagnostics in.

Ports are made and closed on the ROS thread; all else of them is for the loop. Velocity and latch are published from
the loop itself: a stop must not wait for the ROS thread (docs/decisions.md).
"""

import time
from collections.abc import Callable
from functools import partial
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Twist
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.qos_overriding_options import QoSOverridingOptions
from sensor_msgs.msg import BatteryState
from std_msgs.msg import Bool

from dock_gateway.core.goal import GoalError, Json
from dock_gateway.ros.bridge import Bridge, guard
from dock_gateway.ros.messages.codec import codec

# Best effort and volatile matches every publisher: some send batteries with sensor data QoS, others reliably.
LISTEN = QoSProfile(depth=50, reliability=ReliabilityPolicy.BEST_EFFORT, durability=DurabilityPolicy.VOLATILE)
TALK = QoSProfile(depth=10)
# Who comes later gets the last message, too.
LATCHED = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL)

# A message that is stamped so many nanoseconds after we began to publish may be ours.
OWN_WITHIN = 1_000_000_000
# A message of ours may be heard so many nanoseconds late, on a busy machine: taken for that of another gateway, it
# might release a stop.
OWN_REMEMBERED = 20_000_000_000

# Facts about goals and simulators that are taken from one message.
MAX_FACTS = 100
# More digits than these are no number of retries.
MAX_DIGITS = 6

OnMessage = Callable[[Json, int], None]
OnReason = Callable[[str, GoalError], None]
OnSimulator = Callable[[str, dict[str, str]], None]
OnProgress = Callable[[str, str | None, int | None, int], None]

# How the status of a simulator is named, after the namespace.
SIMULATOR = "dock_simulator"

# Stages that are the end of a goal, which its status tells.
ENDS = frozenset({"SUCCEEDED", "CANCELED", "ABORTED", "REJECTED"})


class BatteryPort:
    """`sensor_msgs/BatteryState`, heard and published."""

    def __init__(self, bridge: Bridge, topic: str, on_battery: OnMessage) -> None:
        self._bridge = bridge
        self.codec = codec(BatteryState)
        overrides = QoSOverridingOptions.with_default_policies()
        self._publisher = bridge.node.create_publisher(BatteryState, topic, TALK, qos_overriding_options=overrides)

        inbox = bridge.inbox()

        def hear(message: BatteryState, info: dict[str, Any]) -> None:
            state = self.codec.encode(message)
            inbox.offer(len(state), on_battery, state, info["source_timestamp"])

        self._subscription = bridge.node.create_subscription(
            BatteryState, topic, guard(hear), LISTEN, qos_overriding_options=overrides
        )

    def close(self) -> None:
        """Leave the topic."""
        self._bridge.node.destroy_subscription(self._subscription)
        self._bridge.node.destroy_publisher(self._publisher)

    async def publish(self, message: BatteryState, *, stamp: bool) -> Json:
        """Publish a message, with the time of now where `stamp`; returns it as it went out."""

        def publish() -> Json:
            if stamp:
                message.header.stamp = self._bridge.node.get_clock().now().to_msg()
            self._publisher.publish(message)
            return self.codec.encode(message)

        return await self._bridge.call(publish)


class VelocityPort:
    """`geometry_msgs/Twist`: zero, in m/s and rad/s, for a robot that is to stand still."""

    def __init__(self, bridge: Bridge, topic: str) -> None:
        self._bridge = bridge
        overrides = QoSOverridingOptions.with_default_policies()
        self._publisher = bridge.node.create_publisher(Twist, topic, TALK, qos_overriding_options=overrides)

    def close(self) -> None:
        """Leave the topic."""
        self._bridge.node.destroy_publisher(self._publisher)

    def publish_zero(self) -> None:
        """Tell the robot to stand still, now.

        Raises:
            Exception: ROS does not take the message.
        """
        self._publisher.publish(Twist())


class VelocityListener:
    """`geometry_msgs/Twist`: what a robot is told, in m/s and rad/s, by anyone; heard while somebody wants to see it.

    Args:
        bridge: Where the ROS thread is.
        topic: Absolute name.
        on_velocity: Called on the loop with a message and its source timestamp in ns.
    """

    def __init__(self, bridge: Bridge, topic: str, on_velocity: OnMessage) -> None:
        self._bridge = bridge
        twist_codec = codec(Twist)

        inbox = bridge.inbox()

        def hear(message: Twist, info: dict[str, Any]) -> None:
            velocity = twist_codec.encode(message)
            inbox.offer(len(velocity), on_velocity, velocity, info["source_timestamp"])

        overrides = QoSOverridingOptions.with_default_policies()
        self._subscription = bridge.node.create_subscription(
            Twist, topic, guard(hear), LISTEN, qos_overriding_options=overrides
        )

    def close(self) -> None:
        """Leave the topic."""
        self._bridge.node.destroy_subscription(self._subscription)


class LatchPort:
    """`std_msgs/Bool` on `stop_latched`: whether a stop holds for the robot; the last message counts.

    Args:
        bridge: Where the ROS thread is.
        topic: Absolute name.
        on_latch: Called on the loop with what others say, and when that came in, on the monotonic clock.
    """

    def __init__(self, bridge: Bridge, topic: str, on_latch: Callable[[bool, float], None]) -> None:
        self._bridge = bridge
        self._topic = topic
        self._own: tuple[tuple[int, int], ...] = ()  # when we published: the listener is another thread
        self._publisher = self._make_publisher()
        inbox = bridge.inbox()

        def hear(message: Bool, info: dict[str, Any]) -> None:
            stamp = info["source_timestamp"]
            if not any(first <= stamp <= last for first, last in reversed(self._own)):
                inbox.put(on_latch, message.data, time.monotonic())

        self._subscription = bridge.node.create_subscription(Bool, topic, guard(hear), LATCHED)

    def _make_publisher(self) -> Publisher:
        return self._bridge.node.create_publisher(Bool, self._topic, LATCHED)

    def close(self) -> None:
        """Leave the topic."""
        self._bridge.node.destroy_subscription(self._subscription)
        self._bridge.node.destroy_publisher(self._publisher)

    def publish(self, *, latched: bool) -> None:
        """Publish it, now; late subscribers get the last message.

        Raises:
            Exception: ROS does not take the message.
        """
        first = time.time_ns()
        before = tuple(own for own in self._own if own[1] > first - OWN_REMEMBERED)
        self._own = (*before, (first, first + OWN_WITHIN))  # it may be heard before the end is known
        try:
            self._publisher.publish(Bool(data=latched))
        finally:
            self._own = (*before, (first, time.time_ns()))

    async def withdraw(self) -> None:
        """Late subscribers get no message from us any more.

        Raises:
            Unavailable: The ROS thread is down.
        """

        def withdraw() -> None:
            # The new publisher first: the loop may publish at any time.
            old, self._publisher = self._publisher, self._make_publisher()
            self._bridge.node.destroy_publisher(old)

        await self._bridge.call(withdraw, even_late=True)


class DiagnosticsPort:
    """`diagnostic_msgs/DiagnosticArray`: how far a goal is, and why an action server rejected or aborted it.

    ROS's action protocol has no place for either. A server that wants to say it publishes a DiagnosticStatus whose
    values (REP 107) hold `goal_id`, `error_code` and `error_msg`, `stage` and `retries`. Where they hold a `stage`, it
    is the error at the end of a goal that counts, not what a running one waits for. A simulator says how it is, too.

    Args:
        bridge: Where the ROS thread is.
        topic: Absolute name.
        on_reason: Called on the loop with a goal id and why it was rejected or aborted.
        on_progress: Called on the loop with a goal id, stage, retries, and the source timestamp in ns.
        on_simulator: Called on the loop with the namespace of a simulator and its key values.
    """

    def __init__(
        self,
        bridge: Bridge,
        topic: str,
        *,
        on_reason: OnReason,
        on_progress: OnProgress,
        on_simulator: OnSimulator,
    ) -> None:
        inbox = bridge.inbox()

        def tell(facts: list[Callable[[], None]]) -> None:
            for fact in facts:
                fact()

        def hear(message: DiagnosticArray, info: dict[str, Any]) -> None:
            facts: list[Callable[[], None]] = []
            for status in message.status:
                values = {pair.key: pair.value for pair in status.values}
                namespace, _, name = f"/{status.name}".rpartition("/")
                if name == SIMULATOR:
                    facts.append(partial(on_simulator, namespace or "/", values))
                if goal_id := values.get("goal_id"):
                    if (error := _read_error(values, status.message)) is not None:
                        facts.append(partial(on_reason, goal_id, error))
                    facts.append(partial(on_progress, goal_id, *_read_progress(values), info["source_timestamp"]))
                if len(facts) >= MAX_FACTS:
                    break
            if facts:
                inbox.offer(len(facts), tell, facts)

        bridge.node.create_subscription(DiagnosticArray, topic, guard(hear), LISTEN)


def _read_error(values: dict[str, str], message: str) -> GoalError | None:
    """Why a goal was rejected or aborted, out of the values of a status."""
    code = values.get("error_code")
    if not code or code in ("0", "NONE") or values.get("stage") not in (None, "ABORTED", "REJECTED"):
        return None
    return GoalError(code.lower(), values.get("error_msg") or message)


def _read_progress(values: dict[str, str]) -> tuple[str | None, int | None]:
    """Stage and retries, likewise."""
    stage, retries = values.get("stage"), values.get("retries", "")
    count = int(retries) if retries.isdecimal() and len(retries) <= MAX_DIGITS else None
    return None if stage in ENDS else stage, count
