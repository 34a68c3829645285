"""Reports what becomes of goals: in the log, and on `/diagnostics`."""

from dataclasses import replace
from typing import TypeVar

from rclpy.node import Node

from docking.core.battery import Battery
from docking.core.errors import ErrorCode, Stage
from docking.goal.admission import Rejection
from docking.goal.outcome import Command, End, Outcome
from docking.goal.report import Report, report_on
from docking.ros.battery_subscriber import BATTERY_TOPIC, BatterySearch
from docking.ros.diagnostics import Diagnostics
from docking.ros.rivals import DRIVEN, Rivals
from docking.ros.sensors import MARKER_TOPIC, Sensors
from docking.ros.velocity_publisher import VelocityPublisher

Event = TypeVar("Event", Command, Outcome)

SENSED = frozenset(
    {
        ErrorCode.FAILED_TO_DETECT_DOCK,
        ErrorCode.LOST_MARKER,
        ErrorCode.INFRARED_LOST,
        ErrorCode.LOCALIZATION_LOST,
        ErrorCode.ODOMETRY_LOST,
        ErrorCode.SCAN_LOST,
    }
)
"""Errors that a sensor's fault may cause."""


class GoalReporter:
    """Reports on the goals of one action server. All calls must come from the thread that spins the node."""

    def __init__(
        self,
        node: Node,
        action_name: str,
        battery: Battery,
        sensors: Sensors,
        velocity: VelocityPublisher,
    ) -> None:
        """Report that no goal has come yet.

        Args:
            node: The node that publishes.
            action_name: What the reports are about.
            battery: Whose faults are reported, as are those of the next two.
            sensors: Those of the goals.
            velocity: Publishes `cmd_vel`.
        """
        self._node = node
        self._battery = battery
        self._battery_search = BatterySearch(node)
        self._sensors = sensors
        self._rivals = Rivals(node)
        self._velocity = velocity
        self._diagnostics = Diagnostics(node, action_name)
        self._report = Report()
        self._stage = Stage.IDLE
        self._note = ""  # about unusual detections
        self._memory = ""

    def reject(self, rejection: Rejection, goal_id: str, *, running: bool) -> None:
        """Report a rejection, but only once if a goal runs, which stays the subject."""
        self._node.get_logger().warning(
            f"Goal {goal_id} rejected: {rejection.error_msg} [{rejection.error_code.value}]"
        )
        report = report_on(rejection, goal_id)
        if not running:
            self._report = report
        self._publish(report)

    def begin(self, memory: str) -> None:
        """A goal was accepted: see who drives along.

        Args:
            memory: What is known from earlier goals, for its recording.
        """
        self._memory = memory
        self._stage = Stage.IDLE
        self._note = ""
        self._rivals.scan()

    def go_on(self, step: Command, goal_id: str) -> None:
        """Report what a goal does, where that has changed."""
        logger = self._node.get_logger()
        if step.note and not self._note:
            logger.warning(f"Goal {goal_id}: {step.note}")
        self._note = step.note
        report = report_on(self._explained(step), goal_id)
        if report != self._report:
            self._report = report
            if report.error_msg:
                verb = "tries again" if report.stage is Stage.RETRY else "waits"
                logger.warning(f"Goal {goal_id} {verb}: {report.error_msg} [{report.error_code.value}]")
            elif self._stage not in {report.stage, Stage.IDLE}:
                logger.info(f"Goal {goal_id}: {report.message}")
            self._publish(replace(report, memory=self._memory))
            self._memory = ""
        self._stage = step.stage

    def end(self, outcome: Outcome, goal_id: str) -> None:
        """Report how a goal ended, from now on."""
        outcome = self._explained(outcome)
        logger = self._node.get_logger()
        if outcome.end is End.CANCELED:
            logger.info(f"Goal {goal_id} canceled")
        elif outcome.end is End.ABORTED:
            logger.error(f"Goal {goal_id} aborted: {outcome.error_msg} [{outcome.error_code.value}]")
        self._report = report_on(outcome, goal_id)
        self._publish(self._report)

    def refresh(self) -> None:
        """See who drives along, and publish the last report again; call it once a second."""
        self._rivals.scan()
        self.repeat()

    def repeat(self) -> None:
        """Publish the last report again, with the current faults."""
        self._publish(self._report)

    def _explained(self, event: Event) -> Event:
        """Add possible causes to an error: faults of sensors, other nodes that drive, or why there is no battery."""
        if event.error_code in (ErrorCode.BATTERY_STALE, ErrorCode.BATTERY_LOST) and self._battery.latest is None:
            return replace(event, error_msg=f"{event.error_msg}; {self._battery_search.describe()}")
        faults: list[str] = list(self._sensors.faults.values()) if event.error_code in SENSED else []
        if event.error_code in SENSED | DRIVEN:
            faults += self._rivals.faults.values()
        return replace(event, error_msg="; ".join([event.error_msg, *faults])) if faults else event

    def _publish(self, report: Report) -> None:
        battery, topic = self._battery.latest, self._node.resolve_topic_name(BATTERY_TOPIC)
        warnings = {} if battery is None or battery.fault is None else {topic: f"{topic} {battery.fault}"}
        if self._note:
            topic = self._node.resolve_topic_name(MARKER_TOPIC)
            warnings[topic] = f"{topic}: {self._note}"
        warnings |= self._rivals.faults
        if (mismatch := self._velocity.mismatch) is not None:
            warnings[self._node.resolve_topic_name("cmd_vel")] = mismatch
        self._diagnostics.publish(report, self._sensors.faults, warnings)
