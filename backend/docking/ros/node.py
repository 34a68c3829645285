"""A node that serves an action which drives the robot: docking or undocking, as its `RobotAction` says."""

import math
import time
import traceback
from functools import partial
from typing import Any, Generic

from rclpy.action import CancelResponse, GoalResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.context import Context
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn

from docking.core.battery import Battery
from docking.core.errors import DockingError, ErrorCode
from docking.core.observation import STANDSTILL
from docking.goal.admission import Rejection, admit
from docking.goal.engine import Goal
from docking.goal.nearest_dock import NearestDock
from docking.goal.outcome import End, Outcome
from docking.parameters import read_topics
from docking.ros.active_goal import ActiveGoal, Execution
from docking.ros.battery_subscriber import battery_message
from docking.ros.clock import ClockWatch, control_time
from docking.ros.detector import DetectorClient
from docking.ros.dock_calibrator import DockCalibrator
from docking.ros.dock_reloader import DockReloader
from docking.ros.footprint import FootprintPublisher
from docking.ros.goal_reporter import GoalReporter
from docking.ros.navigation import NavigationClient
from docking.ros.parameters import declare_parameters
from docking.ros.poses import PosePublishers
from docking.ros.robot_action import RobotAction, S
from docking.ros.sensors import Sensor, Sensors
from docking.ros.stop_listener import StopListener
from docking.ros.transforms import Transforms
from docking.ros.velocity import Drive
from robot_io.endpoints import WithoutEvents
from robot_io.rclpy_private import IdentifyingActionServer, goal_id_text

FEEDBACK_PERIOD = 0.1
BASE = "base_link"
NAV2_NODE = "docking_server"
"""The name of nav2's node: parameters for it are for the nodes of both actions."""
DIAGNOSTICS_PERIOD = 1.0


class ActionNode(WithoutEvents, LifecycleNode, Generic[S]):  # type: ignore[misc] # rclpy has no types
    """Serves an action whose goals move the robot; publishes `cmd_vel` and `/diagnostics`.

    It is a lifecycle node: goals are rejected unless it is active, which it becomes by itself (`autostart`).
    Everything here runs in the one thread that spins the node.
    """

    def __init__(
        self,
        action: RobotAction[S],
        battery: Battery,
        *,
        active_goal: ActiveGoal | None = None,
        clock_watch: ClockWatch | None = None,
        context: Context | None = None,
        **options: Any,
    ) -> None:
        """Make the node.

        Args:
            action: The action.
            battery: Where the battery subscriber puts its readings.
            active_goal: Shared by all servers that drive this robot; None where there is no other.
            clock_watch: Sees whether a simulated clock stands still; None is one that compares it with real time.
            context: The ROS context; None is the default one.
            options: For rclpy's Node.

        Raises:
            rclpy.exceptions.ParameterException: A parameter is wrong.
            ValueError: The parameters cannot work together.
        """
        super().__init__(action.node_name, context=context, **options)
        self._action = action
        self._battery = battery
        self._active_goal = active_goal or ActiveGoal()
        self._running: Execution | None = None  # None also while a goal of another server runs
        self._closing = self._active = False
        self._fed_back_at = -math.inf
        self._clock_watch = clock_watch or ClockWatch(self)
        self._transforms = Transforms(self)
        self._sensors = Sensors(self, self._transforms, self._repeat_report)
        self._navigation = NavigationClient(self)
        self._detector = DetectorClient(self)
        self._poses = PosePublishers(self)
        self._footprint = FootprintPublisher(self)
        self._calibrator = DockCalibrator(
            self, battery, self._transforms, self._active_goal, lambda: self._settings.dock_types
        )
        parameters = declare_parameters(self, action.settings_type, self._take_over, alias=NAV2_NODE)
        if action.knows_docks:
            DockReloader(self, parameters)
        self._drive = Drive(self, lambda: self._sensors.odometry)
        self._reporter = GoalReporter(self, action.action_name, battery, self._sensors, self._drive.publisher)
        self._server = IdentifyingActionServer(
            self,
            action.action_type,
            action.action_name,
            execute_callback=self._execute,
            goal_callback=self._decide,
            handle_accepted_callback=self.accept,
            cancel_callback=self._cancel,
        )
        self._stops = StopListener(self, self._obey_stop)
        # A simulated clock that stands still must not stop these.
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._control_timer = self.create_timer(FEEDBACK_PERIOD, self.control, clock=steady)
        self._control_timer.cancel()
        self._diagnostics_timer = self.create_timer(DIAGNOSTICS_PERIOD, self._check_graph, clock=steady)
        self._show()
        if action.ends_with_charge:
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
        self._abort(ErrorCode.NOT_ACTIVE, "the action server's node was deactivated")

    @property
    def own_name(self) -> str:
        """The name of the node unless it is renamed."""
        return self._action.node_name

    @property
    def action_type(self) -> Any:
        """The type of the action."""
        return self._action.action_type

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
        if self._action.shows_footprint:
            self._footprint.publish(self._settings.outline.points, base)
        if self._running is None:
            by_marker = self._action.detects_marker(self._settings)
            self._navigation.switch(on=self._settings.navigates)
            self._transforms.switch(on=self._action.uses_frames(self._settings), prefix=self._settings.frame_prefix)
            self._poses.switch(on=by_marker)
            self._calibrator.switch(on=by_marker)

    # A goal comes: it is decided on, accepted, executed.

    def _decide(self, request: Any) -> GoalResponse:
        running = self._active_goal.running
        rejection = admit(
            request.desired_battery_state.power_supply_status,
            self._action.purpose,
            active_goal_id=None if running is None else running.goal_id,
            policy=self._settings.goal_policy,
            stop_latched=self._stops.held,
            shutting_down=self._closing,
            active=self._active,
        )
        if rejection is None:
            try:
                self._settings.at_dock(request.desired_battery_state.location)
            except DockingError as error:
                rejection = Rejection(error.error_code, str(error))
            else:
                return GoalResponse.ACCEPT
        self._reporter.reject(rejection, self._server.deciding_on, running=self._running is not None)
        return GoalResponse.REJECT

    def accept(self, handle: ServerGoalHandle) -> None:
        """Begin with a goal that was let in."""
        goal_id = goal_id_text(handle.goal_id)
        running = self._active_goal.running
        if running is not None:
            running.end(running.goal.abort(ErrorCode.PREEMPTED, f"preempted by goal {goal_id}"))
        settings = self._settings.at_dock(handle.request.desired_battery_state.location)
        now = control_time(self)
        memory = self._active_goal.memory.as_json(now)
        goal, nearest = self._make(settings, now)
        execution = Execution(handle, goal_id, goal, self._end, nearest, waits_for_clock=now == 0.0)
        self._running = self._active_goal.running = execution
        self._clock_watch.begin()
        self._reporter.begin(memory)
        self._fed_back_at = -math.inf
        self._drive.begin()
        handle.execute(partial(self._execute, execution))
        try:
            self._prepare(goal, settings)
        except Exception as error:  # noqa: BLE001 - such as a `qos_overrides` parameter that is wrong
            self._fail(error)

    def _make(self, settings: S, now: float) -> tuple[Goal, NearestDock | None]:
        """Return a goal that begins now, and what finds its dock, if that is to be the nearest one."""
        nearest = NearestDock(settings.choices, now) if settings.choices else None
        return self._action.make_goal(settings, self._active_goal.memory, now), nearest

    def _prepare(self, goal: Goal, settings: S) -> None:
        needs = self._action.needs(settings)
        self._sensors.scanner = self._settings.collision.mount
        self._sensors.marker_tilt = settings.marker_tilt
        self._sensors.joint_names = frozenset(settings.joints)
        self._sensors.place = settings.place if Sensor.ODOMETRY in needs else None
        self._transforms.switch(on=self._action.uses_frames(settings), prefix=self._settings.frame_prefix)
        self._sensors.listen_to(needs)
        self._control_timer.timer_period_ns = round(self._settings.control_period * 1e9)
        detector = self._detector.detector(settings.switched) if Sensor.MARKER in needs else None
        if detector is not None:
            goal.detect_with(detector)
        if settings.staging_goal is not None:
            self._transforms.use(self._navigation, on=True)
            goal.navigate_first(self._navigation.navigation(settings.staging_goal, self._sensors))

    async def _execute(self, execution: Execution, handle: ServerGoalHandle) -> Any:
        if execution is self._running:
            self.get_logger().info("Executing goal...")
            self._control_timer.reset()
            self.control()
        outcome: Outcome = await execution.ended
        result = self._action.action_type.Result(final_battery_state=battery_message(self._battery))  # type: ignore[attr-defined]
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
        if self._stops.held and self._active_goal.running is not None:
            # What else came is dealt with first: a gateway cancels goals before it latches, and a canceled goal is one.
            self.executor.create_task(self._end_by_stop)

    def _end_by_stop(self) -> None:
        running = self._active_goal.running
        if running is not None:
            running.end(running.goal.abort(ErrorCode.STOP_LATCHED, "a stop was latched"))

    # A goal runs, and ends.

    def control(self) -> None:
        """Do the next control step, if a goal of this server runs."""
        if self._running is None:
            return
        try:
            self._step(self._running)
        except Exception as error:  # noqa: BLE001 - whatever it is, the robot must stop and the server go on
            self._fail(error)

    def _fail(self, error: Exception) -> None:
        self.get_logger().error("".join(traceback.format_exception(error)))
        self._abort(ErrorCode.UNKNOWN, f"{type(error).__name__}: {error}")

    def _abort(self, error_code: ErrorCode, error_msg: str) -> None:
        """Abort the goal of this server that runs, if there is one."""
        running = self._running
        if running is not None:
            self._end(running.goal.abort(error_code, error_msg))

    def _step(self, running: Execution) -> None:
        decided_at = time.monotonic()
        if self._clock_watch.stopped or not self._has_begun(running):
            running.goal.pause()
            self._drive.go(STANDSTILL, decided_at)
            return
        observation = self._sensors.observe(self._battery.latest)
        if running.nearest is not None and not self._choose_dock(running, running.nearest):
            return
        if doubt := self._clock_watch.doubt:
            running.goal.doubts.note("clock", doubt)
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
        robot = None if observation.odometry is None else observation.odometry.pose
        self._poses.publish(step, self._sensors.odometry_frame, robot)
        stage, line = self._action.progress
        if step.stage is stage and not step.error_msg:
            self.get_logger().info(line, throttle_duration_sec=1.0)
        self._reporter.go_on(step, running.goal_id)

    def _has_begun(self, running: Execution) -> bool:
        """Begin with a goal that waits for the clock once there is one; whether it has begun.

        The time before it is 0: a goal that began then would have lasted for years.
        """
        now = control_time(self)
        if running.waits_for_clock and now != 0.0:
            settings = self._settings.at_dock(running.handle.request.desired_battery_state.location)
            running.goal, running.nearest = self._make(settings, now)
            running.waits_for_clock = False
            self._clock_watch.begin()
            self._prepare(running.goal, settings)
        return not running.waits_for_clock

    def _choose_dock(self, running: Execution, nearest: NearestDock) -> bool:
        """Begin with the goal for the nearest dock once that is known; whether it has begun."""
        try:
            place = nearest.find(control_time(self), self._sensors.robot_in)
        except DockingError as error:
            self._end(running.goal.abort(error.error_code, str(error)))
            return False
        if place is None:
            self._drive.go(STANDSTILL, time.monotonic())
            return False
        self.get_logger().info(f"The nearest dock is '{place.dock}'.")
        settings = self._settings.at_dock(place.dock)
        running.goal, running.nearest = self._make(settings, control_time(self))
        self._prepare(running.goal, settings)
        return True

    def _end(self, outcome: Outcome) -> None:
        """End the goal of this server that runs: the robot stops, whatever the outcome."""
        running, self._running = self._running, None
        if running is None:
            return
        self._active_goal.running = None
        self._control_timer.cancel()
        self._drive.stop()
        if outcome.end is End.SUCCEEDED:
            running.handle.publish_feedback(self._feedback())
            running.handle.succeed()
            for line in self._action.success:
                self.get_logger().info(line)
        elif outcome.end is End.ABORTED:
            running.handle.abort()  # at once: of all goals to cancel, rclpy skips the one after a goal that refuses
        running.ended.set_result(outcome)
        self._reporter.end(outcome, running.goal_id)
        self._poses.end()
        self._transforms.use(self._navigation, on=False)
        self._detector.end()
        self._sensors.listen_to(frozenset({Sensor.ODOMETRY}), only_known=True)  # until the robot stands
        self._show()

    def _feedback(self) -> Any:
        return self._action.action_type.Feedback(current_battery_state=battery_message(self._battery))  # type: ignore[attr-defined]

    def _check_graph(self) -> None:
        running = self._running is not None
        self._drive.follow_graph(needed=running)
        if not (running or self._drive.halting):
            self._sensors.listen_to(frozenset())  # an idle node costs next to nothing
        self._stops.scan()
        self._reporter.refresh()

    def _repeat_report(self) -> None:
        self._reporter.repeat()

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
        self._abort(ErrorCode.SHUTTING_DOWN, "the action server is shutting down")

    def hold_still(self) -> None:
        """Stop the robot if this server drives it or did a moment ago, unless that is done.

        Any thread may call it. It never raises.
        """
        if self._running is not None or self._drive.recent:
            self._drive.hold_still()

    @property
    def halting(self) -> bool:
        """Whether the robot is being stopped: zero velocity is repeated until it stands."""
        return self._drive.halting
