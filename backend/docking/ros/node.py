"""A node that serves an action which drives the robot: docking or undocking, as its `ActionSpec` says."""

import math
import time
import traceback
from dataclasses import replace
from functools import partial
from typing import Any, Generic, TypeVar

from rclpy.action import CancelResponse, GoalResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.context import Context
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn

from docking.core.battery import Battery
from docking.core.errors import DockNotInDb, ErrorCode, Stage
from docking.core.observation import STANDSTILL
from docking.goal.admission import Rejection, admit
from docking.goal.engine import Command, End, Goal, Outcome
from docking.goal.report import Report, report_on
from docking.parameters import read_topics
from docking.ros.action_spec import ActionSpec, S
from docking.ros.active_goal import ActiveGoal, Execution
from docking.ros.battery_subscriber import BATTERY_TOPIC, BatterySearch, battery_message
from docking.ros.clock import ClockWatch, control_time
from docking.ros.diagnostics import Diagnostics
from docking.ros.dock_calibrator import DockCalibrator
from docking.ros.footprint import FootprintPublisher
from docking.ros.navigation import NavigationClient
from docking.ros.parameters import declare_parameters
from docking.ros.poses import PosePublishers
from docking.ros.rivals import DRIVEN, Rivals
from docking.ros.sensors import MARKER_TOPIC, Sensor, Sensors
from docking.ros.stop_listener import StopListener
from docking.ros.transforms import Transforms
from docking.ros.velocity import Drive
from robot_io.rclpy_private import IdentifyingActionServer, goal_id_text

Event = TypeVar("Event", Command, Outcome)

FEEDBACK_PERIOD = 0.1
BASE = "base_link"
NAV2_NODE = "docking_server"
"""The name of nav2's node: parameters for it are for the nodes of both actions."""
DIAGNOSTICS_PERIOD = 1.0
SENSED = frozenset(
    {
        ErrorCode.FAILED_TO_DETECT_DOCK,
        ErrorCode.LOST_MARKER,
        ErrorCode.INFRARED_LOST,
        ErrorCode.ODOMETRY_LOST,
        ErrorCode.SCAN_LOST,
    }
)
"""What a sensor's fault may be the cause of."""


class ActionNode(LifecycleNode, Generic[S]):  # type: ignore[misc] # rclpy has no types
    """Serves an action whose goals move the robot; publishes `cmd_vel` and `/diagnostics`.

    It is a lifecycle node: goals are rejected unless it is active, which it becomes by itself (`autostart`).
    Everything here runs in the one thread that spins the node.
    """

    def __init__(
        self,
        spec: ActionSpec[S],
        battery: Battery,
        *,
        active_goal: ActiveGoal | None = None,
        context: Context | None = None,
        **options: Any,
    ) -> None:
        """Make the node.

        Args:
            spec: The action.
            battery: Where the battery subscriber puts its readings.
            active_goal: Shared by all servers that drive this robot; None where there is no other.
            context: The ROS context; None is the default one.
            options: For rclpy's Node.

        Raises:
            rclpy.exceptions.ParameterException: A parameter is wrong.
            ValueError: The parameters cannot work together.
        """
        super().__init__(spec.node_name, context=context, **options)
        self._spec = spec
        self._battery = battery
        self._battery_search = BatterySearch(self)
        self._active_goal = active_goal or ActiveGoal()
        self._running: Execution | None = None  # None also while a goal of another server runs
        self._closing = self._active = False
        self._report = Report()
        self._stage = Stage.IDLE
        self._note = ""  # what is odd about the detections
        self._fed_back_at = -math.inf
        self._clock_watch = ClockWatch(self)
        self._transforms = Transforms(self)
        self._sensors = Sensors(self, self._transforms, self._repeat_report)
        self._navigation = NavigationClient(self)
        self._poses = PosePublishers(self)
        self._footprint = FootprintPublisher(self)
        self._calibrator = DockCalibrator(
            self, battery, self._transforms, lambda: self._active_goal.running is not None, self._find_dock_type
        )
        declare_parameters(self, spec.settings, self._take_over, alias=NAV2_NODE)
        self._drive = Drive(self)
        self._rivals = Rivals(self)
        self._diagnostics = Diagnostics(self, spec.action_name)
        self._server = IdentifyingActionServer(
            self,
            spec.action_type,
            spec.action_name,
            execute_callback=self._execute,
            goal_callback=self._decide,
            handle_accepted_callback=self._accept,
            cancel_callback=self._cancel,
        )
        self._stops = StopListener(self, self._obey_stop)
        # A simulated clock that stands still must not stop these.
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._control_timer = self.create_timer(FEEDBACK_PERIOD, self.control, clock=steady)
        self._control_timer.cancel()
        self._diagnostics_timer = self.create_timer(DIAGNOSTICS_PERIOD, self._look_around, clock=steady)
        self._show()
        if spec.ends_with_charge:
            battery.on_connected = self.control  # at once, not at the next turn of the timer

        if self._settings.autostart:
            self.trigger_configure()
            self.trigger_activate()

    # Lifecycle.

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Let goals in."""
        self._active = True
        return super().on_activate(state)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Let no more goals in, and abort the one that runs, which stops the robot."""
        self._leave()
        return super().on_deactivate(state)

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """The same, for good."""
        self._leave()
        return super().on_shutdown(state)

    def _leave(self) -> None:
        self._active = False
        running = self._running
        if running is not None:
            self._end(running.goal.abort(ErrorCode.NOT_ACTIVE, "the action server's node was deactivated"))

    @property
    def own_name(self) -> str:
        """The name of the node unless it is renamed."""
        return self._spec.node_name

    @property
    def settings(self) -> S:
        """The parameters."""
        return self._settings

    # Parameters and equipment.

    def _take_over(self, settings: S) -> None:
        self._settings = settings
        if self.executor is not None:  # else the node is not spun yet, and its maker goes on with this
            self.executor.create_task(self._show)

    def _show(self) -> None:
        """Carry out what follows from the parameters alone, also while a goal runs."""
        self._stops.listen_to(read_topics(self._settings.stop_topics))
        self._drive.publisher.mode = self._settings.enable_stamped_cmd_vel
        self._drive.publisher.frame = base = self._settings.frame_prefix + BASE
        if self._spec.outline is not None:
            self._footprint.publish(self._spec.outline(self._settings), base)
        if self._running is None:
            by_marker = Sensor.MARKER in self._spec.needs(self._settings)
            navigates = self._spec.navigates(self._settings)
            by_frames = (
                by_marker or navigates or self._settings.collision.needs_tf or self._spec.has_places(self._settings)
            )
            self._navigation.switch(on=navigates)
            self._transforms.switch(on=by_frames, prefix=self._settings.frame_prefix)
            self._poses.switch(on=by_marker)
            self._calibrator.switch(on=by_marker)

    def _find_dock_type(self) -> str | None:
        """The type of the dock that the robot is on; empty where there are no types, None if it is not known."""
        types = self._spec.dock_types(self._settings)
        last = self._active_goal.memory.dock_type
        if last in types:
            return last
        return None if len(types) > 1 else "".join(types)

    # A goal comes: it is decided on, accepted, executed.

    def _decide(self, request: Any) -> GoalResponse:
        running = self._active_goal.running
        rejection = admit(
            request.desired_battery_state.power_supply_status,
            self._spec.purpose,
            active_goal_id=None if running is None else running.goal_id,
            policy=self._settings.goal_policy,
            stop_latched=self._stops.held,
            shutting_down=self._closing,
            active=self._active,
        )
        if rejection is None:
            try:
                self._spec.at_dock(self._settings, request.desired_battery_state.location)
            except DockNotInDb as error:
                rejection = Rejection(error.error_code, str(error))
            else:
                return GoalResponse.ACCEPT
        goal_id = self._server.deciding_on
        self.get_logger().warning(f"Goal {goal_id} rejected: {rejection.error_msg} [{rejection.error_code.value}]")
        report = report_on(rejection, goal_id)
        if self._running is None:
            self._report = report
        self._publish_report(report)  # only once if a goal runs, which stays the subject
        return GoalResponse.REJECT

    def _accept(self, handle: ServerGoalHandle) -> None:
        goal_id = goal_id_text(handle.goal_id)
        running = self._active_goal.running
        if running is not None:
            running.end(running.goal.abort(ErrorCode.PREEMPTED, f"preempted by goal {goal_id}"))
        settings = self._spec.at_dock(self._settings, handle.request.desired_battery_state.location)
        goal = self._spec.make_goal(settings, self._active_goal.memory, control_time(self))
        execution = Execution(handle, goal_id, goal, self._end)
        self._running = self._active_goal.running = execution
        self._stage = Stage.IDLE
        self._note = ""
        self._fed_back_at = -math.inf
        self._drive.begin()
        self._rivals.look()
        handle.execute(partial(self._execute, execution))
        try:
            self._prepare(goal, settings)
        except Exception as error:  # noqa: BLE001 - such as a `qos_overrides` parameter that is wrong
            self._fail(execution, error)

    def _prepare(self, goal: Goal, settings: S) -> None:
        self._sensors.scanner = self._settings.collision.mount
        self._sensors.marker_tilt = self._spec.marker_tilt(settings)
        self._sensors.place = self._spec.place(settings)
        self._sensors.listen_to(self._spec.needs(settings))
        self._control_timer.timer_period_ns = round(self._spec.control_period(self._settings) * 1e9)
        if (staging := self._spec.staging(settings)) is not None:
            self._transforms.use(self._navigation, on=True)
            goal.navigate_first(self._navigation.navigation(staging, self._sensors))

    async def _execute(self, execution: Execution, handle: ServerGoalHandle) -> Any:
        if execution is self._running:
            self.get_logger().info("Executing goal...")
            self._control_timer.reset()
            self.control()
        outcome: Outcome = await execution.ended
        result = self._spec.action_type.Result(final_battery_state=battery_message(self._battery))  # type: ignore[attr-defined]
        if outcome.end is End.CANCELED:  # rclpy notes the request after `_cancel`, so that `_end` was too early
            handle.canceled()
        return result

    def _cancel(self, handle: ServerGoalHandle) -> CancelResponse:
        running = self._running
        if running is None or running.goal_id != goal_id_text(handle.goal_id):
            return CancelResponse.REJECT  # it has ended already
        self._end(running.goal.cancel())
        return CancelResponse.ACCEPT

    def _obey_stop(self) -> None:
        running = self._active_goal.running
        if self._stops.held and running is not None:
            running.end(running.goal.abort(ErrorCode.STOP_LATCHED, "a stop was latched"))

    # A goal runs, and ends.

    def control(self) -> None:
        """Do the next control step, if a goal of this server runs."""
        running = self._running
        if running is None:
            return
        try:
            self._step(running)
        except Exception as error:  # noqa: BLE001 - whatever it is, the robot must stop and the server go on
            self._fail(running, error)

    def _fail(self, running: Execution, error: Exception) -> None:
        self.get_logger().error("".join(traceback.format_exception(error)))
        self._end(running.goal.abort(ErrorCode.UNKNOWN, f"{type(error).__name__}: {error}"))

    def _step(self, running: Execution) -> None:
        decided_at = time.monotonic()
        if self._clock_watch.stopped:
            running.goal.pause()
            self._drive.go(STANDSTILL, decided_at)
            return
        observation = self._sensors.observe(self._battery.latest)
        step = running.goal.step(observation)
        if isinstance(step, Outcome):
            self._end(step)
            return
        if step.yields:
            self._drive.leave()
        else:
            self._drive.go(step.velocity, decided_at)
        if observation.now - self._fed_back_at > 0.75 * FEEDBACK_PERIOD:
            self._fed_back_at = observation.now
            running.handle.publish_feedback(self._feedback())
        self._poses.publish(step, self._sensors.odometry_frame)
        if step.stage in self._spec.progress and not step.error_msg:
            self.get_logger().info(self._spec.progress[step.stage], throttle_duration_sec=1.0)
        if step.note and not self._note:
            self.get_logger().warning(f"Goal {running.goal_id}: {step.note}")
        self._note = step.note
        report = report_on(self._explained(step), running.goal_id)
        if report != self._report:
            self._report = report
            self._tell_change(report)
            self._publish_report(report)
        self._stage = step.stage

    def _tell_change(self, report: Report) -> None:
        if report.error_msg:
            verb = "tries again" if report.stage is Stage.RETRY else "waits"
            self.get_logger().warning(f"Goal {report.goal_id} {verb}: {report.error_msg} [{report.error_code.value}]")
        elif self._stage not in {report.stage, Stage.IDLE}:
            self.get_logger().info(f"Goal {report.goal_id}: {report.message}")

    def _end(self, outcome: Outcome) -> None:
        """End the goal of this server that runs: the robot stops, whatever the outcome."""
        running, self._running = self._running, None
        if running is None:
            return
        outcome = self._explained(outcome)
        self._active_goal.running = None
        self._control_timer.cancel()
        self._drive.stop()
        self._report = report_on(outcome, running.goal_id)
        logger = self.get_logger()
        if outcome.end is End.SUCCEEDED:
            running.handle.publish_feedback(self._feedback())
            running.handle.succeed()
            for line in self._spec.success:
                logger.info(line)
        elif outcome.end is End.CANCELED:
            logger.info(f"Goal {running.goal_id} canceled")
        else:
            running.handle.abort()  # at once: of all goals to cancel, rclpy skips the one after a goal that refuses
            logger.error(f"Goal {running.goal_id} aborted: {outcome.error_msg} [{outcome.error_code.value}]")
        running.ended.set_result(outcome)
        self._publish_report(self._report)
        self._transforms.use(self._navigation, on=False)
        self._sensors.listen_to(frozenset())  # an idle node costs next to nothing
        self._show()

    # What is told.

    def _explained(self, event: Event) -> Event:
        """With what may be the cause: what is wrong with the sensors, who drives along, or why there is no battery."""
        if event.error_code in (ErrorCode.BATTERY_STALE, ErrorCode.BATTERY_LOST) and self._battery.latest is None:
            return replace(event, error_msg=f"{event.error_msg}; {self._battery_search.describe()}")
        faults: list[str] = list(self._sensors.faults.values()) if event.error_code in SENSED else []
        if event.error_code in SENSED | DRIVEN:
            faults += self._rivals.faults.values()
        return replace(event, error_msg="; ".join([event.error_msg, *faults])) if faults else event

    def _feedback(self) -> Any:
        return self._spec.action_type.Feedback(current_battery_state=battery_message(self._battery))  # type: ignore[attr-defined]

    def _look_around(self) -> None:
        self._drive.look_again()
        self._rivals.look()
        self._stops.look()
        self._repeat_report()

    def _repeat_report(self) -> None:
        self._publish_report(self._report)

    def _publish_report(self, report: Report) -> None:
        battery, topic = self._battery.latest, self.resolve_topic_name(BATTERY_TOPIC)
        warnings = {} if battery is None or battery.fault is None else {topic: f"{topic} {battery.fault}"}
        if self._note:
            topic = self.resolve_topic_name(MARKER_TOPIC)
            warnings[topic] = f"{topic}: {self._note}"
        warnings |= self._rivals.faults
        if (deaf := self._drive.publisher.fault) is not None:
            warnings[self.resolve_topic_name("cmd_vel")] = deaf
        self._diagnostics.publish(report, self._sensors.faults, warnings)

    # The server ends.

    def destroy_node(self) -> None:
        """Leave the ROS graph, with the action server and the lifecycle services, which rclpy would leave behind."""
        self._drive.close()
        self._server.destroy()
        self._navigation.close()
        state_machine = self._state_machine
        super().destroy_node()
        state_machine.destroy_when_not_in_use()

    def close(self) -> None:
        """Let no more goals in, and abort the one that runs, which stops the robot.

        The node must be spun for another moment, for the goal's result to go out.
        """
        self._closing = True
        self._calibrator.close()
        running = self._running
        if running is not None:
            self._end(running.goal.abort(ErrorCode.SHUTTING_DOWN, "the action server is shutting down"))

    def hold_still(self) -> None:
        """Publish zero velocity if this server drives the robot or did a moment ago.

        Any thread may call it. It never raises.
        """
        if self._running is not None or self._drive.recent:
            self._drive.stop()
