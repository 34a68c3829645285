"""The topics around an action: battery state in and out, the stop latch, diagnostics in.

Ports are created and closed on the ROS thread; their other methods are called on the loop. The latch is published from
the loop itself, because a stop must not wait for the ROS thread (docs/decisions.md).
"""

import time
from collections.abc import Callable
from functools import partial
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.publisher import Publisher
from rclpy.qos_overriding_options import QoSOverridingOptions
from sensor_msgs.msg import BatteryState
from std_msgs.msg import Bool

from dock_gateway.core.goal import GoalError, Json
from dock_gateway.ros.bridge import Bridge, guard
from dock_gateway.ros.messages.codec import codec
from dock_gateway.ros.qos import LATCHED, LISTEN, TALK

# Nanoseconds after the start of a publish call within which a message's stamp may be our own.
OWN_WITHIN = 1_000_000_000
# Nanoseconds that our own message may arrive late, on a busy machine. Mistaken for another gateway's, it might release
# a stop.
OWN_REMEMBERED = 20_000_000_000

# The maximum number of facts about goals and simulators taken from one message.
MAX_FACTS = 100
# The maximum number of digits in a number of retries.
MAX_DIGITS = 6

OnMessage = Callable[[Json, int], None]
OnReason = Callable[[str, GoalError], None]
OnSimulator = Callable[[str, dict[str, str]], None]
OnProgress = Callable[[str, str | None, int | None, int], None]

# The name of a simulator's status, after the namespace.
SIMULATOR = "dock_simulator"

# Stages that end a goal; its status already says so.
ENDS = frozenset({"SUCCEEDED", "CANCELED", "ABORTED", "REJECTED"})


class BatteryPort:
    """`sensor_msgs/BatteryState`, subscribed to and published."""

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
        """Publish a message, with the current time if `stamp`; return it as published."""

        def publish() -> Json:
            if stamp:
                message.header.stamp = self._bridge.node.get_clock().now().to_msg()
            self._publisher.publish(message)
            return self.codec.encode(message)

        return await self._bridge.call(publish)


class LatchPort:
    """`std_msgs/Bool` on `stop_latched`: whether a stop is latched for the robot; the last message counts.

    Args:
        bridge: The bridge to the ROS thread.
        topic: Absolute name.
        on_latch: Called on the loop with the value from others, and when it arrived, on the monotonic clock.
    """

    def __init__(self, bridge: Bridge, topic: str, on_latch: Callable[[bool, float], None]) -> None:
        self._bridge = bridge
        self._topic = topic
        self._own: tuple[tuple[int, int], ...] = ()  # our publish calls; read on the listener's thread
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


class DiagnosticsPort:
    """`diagnostic_msgs/DiagnosticArray`: the progress of a goal, and why an action server rejected or aborted it.

    ROS's action protocol has no field for either. A server may publish a DiagnosticStatus whose values (REP 107) hold
    `goal_id`, `error_code` and `error_msg`, `stage` and `retries`. If they hold a `stage`, only an error at the end of
    a goal counts, not what a running one waits for. Simulators publish their state here, too.

    Args:
        bridge: The bridge to the ROS thread.
        topic: Absolute name.
        on_reason: Called on the loop with a goal id and why the goal was rejected or aborted.
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
    """Read from a status's values why a goal was rejected or aborted."""
    code = values.get("error_code")
    if not code or code in ("0", "NONE") or values.get("stage") not in (None, "ABORTED", "REJECTED"):
        return None
    return GoalError(code.lower(), values.get("error_msg") or message)


def _read_progress(values: dict[str, str]) -> tuple[str | None, int | None]:
    """Read stage and retries from a status's values."""
    stage, retries = values.get("stage"), values.get("retries", "")
    count = int(retries) if retries.isdecimal() and len(retries) <= MAX_DIGITS else None
    return None if stage in ENDS else stage, count
