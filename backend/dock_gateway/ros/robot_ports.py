"""The topics around an action: battery state in and out, diagnostics in.

Ports are created and closed on the ROS thread; their other methods are called on the loop.
"""

from collections.abc import Callable
from functools import partial
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.qos_overriding_options import QoSOverridingOptions
from sensor_msgs.msg import BatteryState

from dock_gateway.core.battery import BOUNDS, CELL_BOUNDS, infinities
from dock_gateway.core.error_codes import code_of_server
from dock_gateway.core.errors import Conflict
from dock_gateway.core.goal import GoalError, Json
from dock_gateway.ros.listener import Handler
from dock_gateway.ros.messages.codec import codec
from dock_gateway.ros.typed_topics import GatewayEndpoints, TypedTopics
from robot_io.qos import LISTEN, TALK

# The maximum number of facts about goals and simulators taken from one message.
MAX_FACTS = 100
# The maximum number of digits in a number of retries.
MAX_DIGITS = 6

# The fields of a BatteryState that are floats, or lists of them.
FLOATS = ("percentage", *BOUNDS, *CELL_BOUNDS)

OnMessage = Callable[[Json, int], None]
OnBattery = Callable[[Json, int, dict[str, Any]], None]
OnReason = Callable[[str, GoalError], None]
OnSimulator = Callable[[str, dict[str, str]], None]
OnProgress = Callable[[str, str | None, int | None, int], None]

# The name of a simulator's status, after the namespace.
SIMULATOR = "dock_simulator"

# Stages that end a goal; its status already says so.
ENDS = frozenset({"SUCCEEDED", "CANCELED", "ABORTED", "REJECTED"})


class BatteryPort:
    """`sensor_msgs/BatteryState`, subscribed to and published.

    Args:
        topics: Joins the topic.
        topic: Absolute name.
        on_battery: Called on the loop with a message, its source timestamp in ns, and its fields that are infinite.
        stop_topic: The topic by whose endpoints gateways are known.
    """

    def __init__(self, topics: TypedTopics, topic: str, on_battery: OnBattery, stop_topic: str) -> None:
        self._bridge = topics.bridge
        self.codec = codec(BatteryState)
        inbox = self._bridge.inbox()

        def hear(message: BatteryState, info: dict[str, Any]) -> None:
            state = self.codec.encode(message)
            infinite = infinities({name: getattr(message, name) for name in FLOATS})
            inbox.offer(len(state), on_battery, state, info["source_timestamp"], infinite)

        overrides = {"qos_overriding_options": QoSOverridingOptions.with_default_policies()}
        endpoints = GatewayEndpoints(((Handler(hear), LISTEN),), publish=TALK, options=overrides)
        self._topic = topics.join(topic, BatteryState, stop_topic, endpoints)

    def close(self) -> None:
        """Leave the topic."""
        self._topic.close()

    async def publish(self, message: BatteryState, *, stamp: bool) -> Json:
        """Publish a message, with the current time if `stamp`; return it as published.

        Raises:
            Conflict: `wrong_topic_type`: the topic is of another type.
            Unavailable: The ROS thread is down.
        """

        def publish() -> Json:
            if self._topic.publisher is None:
                detail = f"{self._topic.name} is of another type than {self._topic.type} on the ROS graph"
                raise Conflict(f"{detail}; see the alerts", code="wrong_topic_type")
            if stamp:
                message.header.stamp = self._bridge.node.get_clock().now().to_msg()
            self._topic.publisher.publish(message)
            return self.codec.encode(message)

        return await self._bridge.call(publish)


class DiagnosticsPort:
    """`diagnostic_msgs/DiagnosticArray`: the progress of a goal, and why an action server rejected or aborted it.

    ROS's action protocol has no field for either. A server may publish a DiagnosticStatus whose values (REP 107) hold
    `goal_id`, `error_code` and `error_msg`, `stage` and `retries`. If they hold a `stage`, only an error at the end of
    a goal counts, not what a running one waits for. Simulators publish their state here, too.

    Args:
        topics: Joins the topic.
        topic: Absolute name.
        on_reason: Called on the loop with a goal id and why the goal was rejected or aborted.
        on_progress: Called on the loop with a goal id, stage, retries, and the source timestamp in ns.
        on_simulator: Called on the loop with the namespace of a simulator and its key values.
        stop_topic: The topic by whose endpoints gateways are known.
    """

    def __init__(
        self,
        topics: TypedTopics,
        topic: str,
        *,
        on_reason: OnReason,
        on_progress: OnProgress,
        on_simulator: OnSimulator,
        stop_topic: str,
    ) -> None:
        inbox = topics.bridge.inbox()

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

        topics.subscribe(topic, DiagnosticArray, stop_topic, Handler(hear), LISTEN)


def _read_error(values: dict[str, str], message: str) -> GoalError | None:
    """Read from a status's values why a goal was rejected or aborted."""
    code = values.get("error_code")
    if not code or code in ("0", "NONE") or values.get("stage") not in (None, "ABORTED", "REJECTED"):
        return None
    return GoalError(code_of_server(code), values.get("error_msg") or message)


def _read_progress(values: dict[str, str]) -> tuple[str | None, int | None]:
    """Read stage and retries from a status's values."""
    stage, retries = values.get("stage"), values.get("retries", "")
    count = int(retries) if retries.isdecimal() and len(retries) <= MAX_DIGITS else None
    return None if stage in ENDS else stage, count
