"""The node `battery_state_subscriber`: puts each battery message where the action server finds it."""

import math
import time
from typing import Any

from rclpy.context import Context
from rclpy.node import Node
from rclpy.qos_overriding_options import QoSOverridingOptions
from sensor_msgs.msg import BatteryState

from docking.core.battery import BATTERY_TYPE, Battery, BatteryReading, describe_absence
from docking.ros.clock import control_time
from robot_io.endpoints import WithoutEvents
from robot_io.qos import LATEST
from robot_io.reception import arrived_at

BATTERY_TOPIC = "battery_status"
SEARCH_PERIOD = 1.0
"""Seconds between two searches for batteries."""


def battery_message(battery: Battery) -> BatteryState:
    """The latest message; before the first, one whose status is UNKNOWN and whose floats are NaN."""
    latest = battery.latest
    if latest is not None and isinstance(latest.message, BatteryState):
        return latest.message
    unmeasured = ("voltage", "temperature", "current", "charge", "capacity", "design_capacity", "percentage")
    return BatteryState(**dict.fromkeys(unmeasured, math.nan))


class BatterySearch:
    """Finds out why no battery messages come."""

    def __init__(self, node: Node) -> None:
        """Nothing is read yet.

        Args:
            node: Who expects them on `battery_status`.
        """
        self._node = node
        self._read_at = -math.inf
        self._words = ""

    def describe(self) -> str:
        """Describe the graph instead, as the end of a sentence; read once a second at most, because it is slow."""
        if time.monotonic() - self._read_at > SEARCH_PERIOD:
            node, topic = self._node, self._node.resolve_topic_name(BATTERY_TOPIC)
            types = [info.topic_type for info in node.get_publishers_info_by_topic(topic)]
            others = [
                name
                for name, kinds in node.get_topic_names_and_types()
                if BATTERY_TYPE in kinds and name != topic and "/_" not in name and node.count_publishers(name)
            ]
            self._words = describe_absence(topic, types, others)
            self._read_at = time.monotonic()
        return self._words


class BatteryStateSubscriber(WithoutEvents, Node):  # type: ignore[misc] # rclpy has no types
    """Subscribes to `battery_status` (sensor_msgs/BatteryState)."""

    def __init__(self, battery: Battery, *, context: Context | None = None) -> None:
        """Make the node.

        Args:
            battery: Where the readings go.
            context: The ROS context; None is the default one.
        """
        super().__init__("battery_state_subscriber", context=context)
        self._battery = battery
        self._subscription = self.create_subscription(
            BatteryState,
            BATTERY_TOPIC,
            self._receive,
            LATEST,
            qos_overriding_options=QoSOverridingOptions.with_default_policies(),
        )

    def _receive(self, message: BatteryState, info: dict[str, Any]) -> None:
        self._battery.update(
            BatteryReading(
                status=message.power_supply_status,
                received_at=arrived_at(info, control_time(self)),
                message=message,
                percentage=message.percentage,
                current=message.current,
            )
        )
