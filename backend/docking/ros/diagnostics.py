"""Reports on `/diagnostics`."""

from collections.abc import Mapping

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.node import Node

from docking.goal.report import Level, Report
from robot_io.endpoints import overridable_publisher


class Diagnostics:
    """Publishes what a node has to report on itself."""

    def __init__(self, node: Node, name: str) -> None:
        """Make the publisher.

        Args:
            node: The node that publishes.
            name: What the reports are about.
        """
        self._node = node
        self._prefix = f"{node.get_fully_qualified_name()[1:]}: "
        self._name = name
        # Absolute, as REP-107 has it: one topic for all robots; the name of the status says which one.
        self._publisher = overridable_publisher(node, DiagnosticArray, "/diagnostics")

    def publish(self, report: Report, errors: Mapping[str, str], warnings: Mapping[str, str]) -> None:
        """Publish a report.

        Args:
            report: On goals.
            errors: Faults of the sensors that goals need, as sentences.
            warnings: The same that goals can do without.
        """
        level = Level.ERROR if errors else Level.WARN if warnings else Level.OK
        faults = {**errors, **warnings}
        array = DiagnosticArray(
            status=[
                status_message(self._prefix + self._name, report.level, report.message, report.values()),
                status_message(f"{self._prefix}sensors", level, "; ".join(faults.values()) or "ok", faults),
            ]
        )
        array.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(array)


def status_message(name: str, level: Level, message: str, values: Mapping[str, str]) -> DiagnosticStatus:
    """One status, with its key values in their order."""
    return DiagnosticStatus(
        level=bytes([level]),
        name=name,
        message=message,
        values=[KeyValue(key=key, value=value) for key, value in values.items()],
    )
