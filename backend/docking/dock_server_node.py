"""The node `connect_to_charging_dock_action_server`: drives the robot until its battery is charging."""

import math
import sys
import time
import traceback
from collections.abc import Callable, Sequence
from concurrent.futures import TimeoutError as CallTimeoutError
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import Twist, Vector3
from rclpy.action import CancelResponse, GoalResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.context import Context
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.qos_overriding_options import QoSOverridingOptions
from rclpy.task import Future
from sensor_msgs.msg import BatteryState

from action_tutorials_interfaces.action import ConnectToChargingDock
from docking.admission import admit
from docking.battery import Battery
from docking.battery_node import BatteryStateSubscriber
from docking.controllers.plan import Solo
from docking.controllers.protocol import Controller
from docking.controllers.rotate import Rotate
from docking.failures import ErrorCode, Stage
from docking.goal import DockGoal, End, Outcome
from docking.observation import STANDSTILL, Observation, Velocity
from docking.parameters import DOCK_SERVER, DockSettings, dock_settings
from docking.report import Report, report_on
from docking.ros.action_server import IdentifyingActionServer, goal_id_text
from docking.ros.parameters import declare_parameters
from docking.ros.process import Spinner, StopSignals, ros_context, run_process

CONTROL_PERIOD = 0.1
DIAGNOSTICS_PERIOD = 1.0
ACKNOWLEDGEMENT_TIMEOUT = 0.5
CLOSE_TIMEOUT = 0.8
LINGER = 0.2


@dataclass(eq=False)
class _Execution:
    """A goal that was accepted, and the future that holds its outcome."""

    handle: ServerGoalHandle
    goal_id: str
    goal: DockGoal
    ended: Future = field(default_factory=Future)


class DockServer(Node):  # type: ignore[misc] # rclpy has no types
    """Action server `connect_to_charging_dock`; publishes `cmd_vel` and `/diagnostics`.

    Everything here runs in the one thread that spins the node.
    """

    def __init__(
        self,
        battery: Battery,
        *,
        make_controller: Callable[[DockSettings], Controller] | None = None,
        context: Context | None = None,
        **options: Any,
    ) -> None:
        """Make the node.

        Args:
            battery: Where the battery subscriber puts its readings.
            make_controller: Makes the controller of each goal; None is `Rotate`.
            context: The ROS context; None is the default one.
            options: For rclpy's Node.

        Raises:
            rclpy.exceptions.ParameterException: A parameter is wrong.
        """
        super().__init__("connect_to_charging_dock_action_server", context=context, **options)
        self._battery = battery
        self._make_controller = make_controller or (lambda settings: Rotate(settings.rotate_speed))
        self._running: _Execution | None = None
        self._closing = False
        self._report = Report()
        self._velocity: Velocity | None = None
        declare_parameters(self, DOCK_SERVER, self._take_settings)
        qos = QoSOverridingOptions.with_default_policies()
        self._cmd_vel = self.create_publisher(Twist, "cmd_vel", 10, qos_overriding_options=qos)
        # Absolute, as REP-107 has it: one topic for all robots, told apart by the name of the status.
        self._diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", 10, qos_overriding_options=qos)
        self._server = IdentifyingActionServer(
            self,
            ConnectToChargingDock,
            "connect_to_charging_dock",
            execute_callback=self._execute,
            goal_callback=self._decide,
            handle_accepted_callback=self._accept,
            cancel_callback=self._cancel,
        )
        # A simulated clock that stands still must not stop these.
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._control_timer = self.create_timer(CONTROL_PERIOD, self._control, clock=steady)
        self._control_timer.cancel()
        battery.on_connected = self._control  # at once, not at the next turn of the timer
        self._diagnostics_timer = self.create_timer(DIAGNOSTICS_PERIOD, self._repeat_report, clock=steady)

    def _take_settings(self, values: dict[str, object]) -> None:
        self._settings = dock_settings(values)

    # A goal comes: it is decided on, accepted, executed.

    def _decide(self, request: ConnectToChargingDock.Goal) -> GoalResponse:
        rejection = admit(
            request.desired_battery_state.power_supply_status,
            active_goal_id=None if self._running is None else self._running.goal_id,
            policy=self._settings.goal_policy,
            shutting_down=self._closing,
        )
        if rejection is None:
            return GoalResponse.ACCEPT
        goal_id = self._server.deciding_on
        self.get_logger().warning(f"Goal {goal_id} rejected: {rejection.error_msg} [{rejection.error_code.value}]")
        report = report_on(rejection, goal_id)
        if self._running is None:
            self._report = report
        self._publish_report(report)  # only once if a goal runs, which stays the subject
        return GoalResponse.REJECT

    def _accept(self, handle: ServerGoalHandle) -> None:
        execution = _Execution(
            handle,
            goal_id_text(handle.goal_id),
            DockGoal(Solo(self._make_controller(self._settings)), self._settings.limits, time.monotonic()),
        )
        if self._running is not None:
            outcome = self._running.goal.abort(ErrorCode.PREEMPTED, f"goal {execution.goal_id} took over")
            self._end(self._running, outcome)
        self._running = execution
        self._velocity = None
        handle.execute(partial(self._execute, execution))

    async def _execute(self, execution: _Execution, handle: ServerGoalHandle) -> ConnectToChargingDock.Result:
        if execution is self._running:
            self.get_logger().info("Executing goal...")
            self._control_timer.reset()
            self._control()
        outcome: Outcome = await execution.ended
        result = ConnectToChargingDock.Result(final_battery_state=self._battery_state())
        if outcome.end is End.SUCCEEDED:
            handle.succeed()
        elif outcome.end is End.CANCELED and handle.is_cancel_requested:
            handle.canceled()
        else:
            handle.abort()
        return result

    def _cancel(self, handle: ServerGoalHandle) -> CancelResponse:
        running = self._running
        if running is None or running.goal_id != goal_id_text(handle.goal_id):
            return CancelResponse.REJECT  # it has ended already
        self._end(running, running.goal.cancel())
        return CancelResponse.ACCEPT

    # A goal runs, and ends.

    def _control(self) -> None:
        running = self._running
        if running is None:
            return
        try:
            self._step(running)
        except Exception as error:  # noqa: BLE001 - whatever it is, the robot must stop and the server go on
            self.get_logger().error(traceback.format_exc())
            self._end(running, running.goal.abort(ErrorCode.UNKNOWN, f"{type(error).__name__}: {error}"))

    def _step(self, running: _Execution) -> None:
        step = running.goal.step(Observation(time.monotonic(), self._battery.latest))
        if isinstance(step, Outcome):
            self._end(running, step)
            return
        self._drive(step.velocity)
        running.handle.publish_feedback(self._feedback())
        if step.stage is Stage.CONTROLLING:
            self.get_logger().info("NOT CHARGING...", throttle_duration_sec=1.0)
        report = report_on(step, running.goal_id)
        if report != self._report:
            if step.error_msg:
                self.get_logger().warning(f"Goal {running.goal_id} waits: {step.error_msg} [{step.error_code.value}]")
            self._report = report
            self._publish_report(report)

    def _end(self, running: _Execution, outcome: Outcome) -> None:
        self._running = None
        self._control_timer.cancel()
        self.stop_robot()
        running.ended.set_result(outcome)
        self._report = report_on(outcome, running.goal_id)
        logger = self.get_logger()
        if outcome.end is End.SUCCEEDED:
            running.handle.publish_feedback(self._feedback())
            logger.info("CHARGING...")
            logger.info("Successfully connected to the charging dock!")
        elif outcome.end is End.CANCELED:
            logger.info(f"Goal {running.goal_id} canceled")
        else:
            logger.error(f"Goal {running.goal_id} aborted: {outcome.error_msg} [{outcome.error_code.value}]")
        self._publish_report(self._report)

    def stop_robot(self) -> None:
        """Publish zero velocity. It never raises: those who call it have other things to end."""
        self._velocity = STANDSTILL
        try:
            self._cmd_vel.publish(Twist())
        except Exception:  # noqa: BLE001 - see above
            self.get_logger().fatal(f"Zero velocity could not be published: {traceback.format_exc()}")

    def _drive(self, velocity: Velocity) -> None:
        """Publish a velocity, but a standstill only once: while the goal waits, the wheels are left to others."""
        if velocity == STANDSTILL == self._velocity:
            return
        self._velocity = velocity
        self._cmd_vel.publish(Twist(linear=Vector3(x=velocity.linear_x), angular=Vector3(z=velocity.angular_z)))

    # What is told.

    def _battery_state(self) -> BatteryState:
        """The latest battery message; before the first, one whose status is UNKNOWN and whose floats are NaN."""
        latest = self._battery.latest
        if latest is not None and isinstance(latest.message, BatteryState):
            return latest.message
        unmeasured = ("voltage", "temperature", "current", "charge", "capacity", "design_capacity", "percentage")
        return BatteryState(**dict.fromkeys(unmeasured, math.nan))

    def _feedback(self) -> ConnectToChargingDock.Feedback:
        return ConnectToChargingDock.Feedback(current_battery_state=self._battery_state())

    def _repeat_report(self) -> None:
        self._publish_report(self._report)

    def _publish_report(self, report: Report) -> None:
        status = DiagnosticStatus(
            level=bytes([report.level]),
            name=f"{self.get_fully_qualified_name()[1:]}: connect_to_charging_dock",
            message=report.message,
            values=[KeyValue(key=key, value=value) for key, value in report.values().items()],
        )
        array = DiagnosticArray(status=[status])
        array.header.stamp = self.get_clock().now().to_msg()
        self._diagnostics.publish(array)

    # The server ends.

    def destroy_node(self) -> None:
        """Leave the ROS graph, with the action server, which rclpy would leave behind."""
        self._server.destroy()
        super().destroy_node()

    def close(self) -> None:
        """Let no more goals in, stop the robot, abort the goal that runs, and wait until all readers know.

        The node must be spun for another moment, for the goal's result to go out.
        """
        self._closing = True
        if self._running is not None:
            message = "the action server is shutting down"
            self._end(self._running, self._running.goal.abort(ErrorCode.SHUTTING_DOWN, message))
        deadline = time.monotonic() + ACKNOWLEDGEMENT_TIMEOUT
        for publisher in (self._cmd_vel, self._diagnostics):
            left = max(0.0, deadline - time.monotonic())
            publisher.wait_for_all_acked(Duration(seconds=left))


def _run(args: Sequence[str] | None) -> int:
    signals = StopSignals()
    with ros_context(args) as context:
        battery = Battery()
        server = DockServer(battery, context=context)
        subscriber = BatteryStateSubscriber(battery, context=context)
        with Spinner(context, [server, subscriber], on_failure=signals.wake) as spinner:
            signals.wait()
            try:
                spinner.call(server.close).result(CLOSE_TIMEOUT)
            except CallTimeoutError:  # a callback hangs
                server.stop_robot()
            time.sleep(LINGER)
        return 0 if spinner.failure is None else 1


def main(args: Sequence[str] | None = None) -> int:
    """Run the action server and the battery subscriber until SIGINT or SIGTERM.

    Returns:
        The exit code: 0 after a signal, 1 after a failure, 2 where a parameter is wrong.
    """
    return run_process(_run, args)


if __name__ == "__main__":
    sys.exit(main())
