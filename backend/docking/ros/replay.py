"""Replays a recorded goal to an action server: with its own clock, at once, and without moving anything.

The server is the real one with its subscriptions, in a process that no other node sees. It is not spun: each recorded
message is handed to the callbacks of its topic, and the control steps come when they came: feedback and velocities tell
when. So a server that a busy machine held up for a moment is held up here, too. Odometry is compared with the recorded
velocities, which are those that the robot followed.
"""

import inspect
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import suppress
from typing import Any, cast

from diagnostic_msgs.msg import DiagnosticArray
from nav_msgs.msg import Odometry
from rclpy.context import Context
from rclpy.node import Node
from rclpy.serialization import deserialize_message
from rclpy.time import Time
from sensor_msgs.msg import BatteryState
from unique_identifier_msgs.msg import UUID

from docking.core.battery import Battery
from docking.core.errors import ErrorCode
from docking.core.observation import STANDSTILL, Observation, Velocity
from docking.goal.dock_memory import DockMemory
from docking.goal.engine import Goal
from docking.goal.outcome import Command, Outcome
from docking.replay.course import Course
from docking.replay.recorded_goal import NS, RecordedGoal
from docking.replay.stutter import stutter_before
from docking.ros.active_goal import ActiveGoal
from docking.ros.battery_subscriber import BatteryStateSubscriber
from docking.ros.clock import ClockWatch
from docking.ros.node import FEEDBACK_PERIOD, ActionNode
from docking.ros.robot_action import RobotAction
from robot_io.recording import Sample
from robot_io.velocity import CLASSES, twist_of

AFTER = 5.0
"""Seconds after the recorded end in which the goal may still end."""
ALIVE = 1.5
"""Periods of feedback, or of control, without a sign of the recorded server after which it made no control step."""
LAGS = (0.0, 0.05, 0.1, 0.2)
"""Seconds by which sensors may have reached the recorded server later than the gateway: the recording does not tell."""
NEEDED = (BatteryState, Odometry)
"""What a server that listens to it cannot do without. Other sensors may have said nothing."""
UNHEARD = frozenset(code.value for code in (ErrorCode.BATTERY_LOST, ErrorCode.BATTERY_STALE, ErrorCode.ODOMETRY_LOST))
"""Errors for which it may be missing."""
Hear = Callable[[float, Command | Outcome], None]


class Replay:
    """One goal, replayed.

    Attributes:
        recorded: What was recorded, with its velocities.
        replayed: What became of the goal now.
        stepped: When the recorded server made control steps, in seconds since the goal was accepted.
        measured: When odometry came that the server listened to.
        cut_at: When the recording has a gap, or the goal takes too long, so that the rest is not replayed, in seconds
            since the goal was accepted; None if all of it is.
    """

    def __init__(self, goal: RecordedGoal, action: RobotAction[Any], context: Context, lag: float = 0.0) -> None:
        """Make the action server.

        Args:
            goal: The recorded goal.
            action: Its action.
            context: The ROS context, with the robot's parameters and `use_sim_time`.
            lag: See `LAGS`.

        Raises:
            ValueError: The goal cannot be replayed; the error says why, as a sentence.
        """
        self.recorded, self.cut_at = goal.course.until(goal.heard_until)
        self.replayed = Course()
        self.stepped: list[float] = []
        self.measured: list[float] = []
        self._listened: set[str] = set()
        self._heard: set[str] = set()
        self._unread: Counter[str] = Counter()
        self._goal = goal
        self._lag_ns = round(lag * NS)
        battery = Battery()
        watched = cast("RobotAction[Any]", _WatchedAction(action, self._hear, self._follow_goal))
        self._following: Goal | None = None
        running = cast("ClockWatch", _RunningClock())
        self._server: ActionNode[Any] = ActionNode(
            watched, battery, active_goal=ActiveGoal(memory=_memory(goal)), clock_watch=running, context=context
        )
        self._nodes: tuple[Node, ...] = (self._server, BatteryStateSubscriber(battery, context=context))
        if self._server.settings.navigates:
            raise ValueError("nav2 drives this robot to its staging pose, which cannot be replayed")
        self._velocity_topic = self._server.resolve_topic_name("cmd_vel")
        self._feedback_topic = f"{goal.action}/_action/feedback"

    def run(self) -> None:
        """Replay the goal to its end."""
        began_ns, period = self._goal.began_ns, round(self._server.settings.control_period * NS)
        alive = round(ALIVE * max(period, FEEDBACK_PERIOD * NS))
        ended_ns = began_ns + round(self.recorded.ended_at * NS)
        signs = any(self._is_feedback(sample) for sample in self._goal.samples)
        due: int | None = None
        sign_ns = stepped_ns = began_ns
        for at_ns, sample in self._timeline():
            if due is None and at_ns >= began_ns:
                self._set_time(began_ns)
                self._server.accept(_Handle(self._goal, self._server.action_type))
                due = began_ns
            commanded, is_sign = sample.topic == self._velocity_topic, self._is_sign(sample)
            while due is not None and due <= at_ns - (period // 2 if is_sign else 0):
                if signs and due - sign_ns > alive and due < ended_ns:
                    due = at_ns + 1
                    break
                self._step(due)
                stepped_ns, due = due, due + period
            self._set_time(at_ns)
            if due is not None and is_sign:
                sign_ns = at_ns
                self.stepped.append(self._goal.seconds(sample))
                if commanded or at_ns - stepped_ns > period // 2:
                    self._step(at_ns)
                    stepped_ns, due = at_ns, at_ns + period
            self._hand_over(sample)
            if self.replayed.end or self._is_over((at_ns - began_ns) / NS):
                return

    def find_doubt(self, at: float) -> str | None:
        """Return why the recording does not allow a verdict on a difference at a moment; None if it does."""
        for topic, count in self._unread.items():
            return f"{count} messages on {topic} cannot be read"
        for topic in sorted(self._listened - self._heard):
            return f"the recording has no messages on {topic}, which the server needs"
        stutter = stutter_before(at, [0.0, *self.stepped], "the server") or stutter_before(
            at, self.measured, "odometry"
        )
        if stutter is None:
            return None
        return (
            f"{stutter.what} was held up for {stutter.seconds:.1f} s at {stutter.at:.1f} s, as on a busy machine, and"
            " what the server knew then is not in the recording"
        )

    def _is_over(self, at: float) -> bool:
        if self.cut_at is not None and at > self.cut_at:
            return True
        return bool(self.recorded.end) and at > self.recorded.ended_at + AFTER

    def _timeline(self) -> Iterator[tuple[int, Sample]]:
        """Yield each message with the moment at which the server gets it, or made it."""
        moments = [
            (sample.received_ns + (0 if self._is_sign(sample) else self._lag_ns), sample)
            for sample in self._goal.samples
        ]
        yield from sorted(moments, key=lambda each: each[0])

    def _is_sign(self, sample: Sample) -> bool:
        """Return whether a message tells of a control step of the recorded server."""
        return sample.topic == self._velocity_topic or self._is_feedback(sample)

    def _is_feedback(self, sample: Sample) -> bool:
        return sample.topic == self._feedback_topic and sample.data[4:20] == self._goal.uuid

    def _step(self, at_ns: int) -> None:
        self._set_time(at_ns)
        self._server.control()
        self._follow()

    def _follow(self) -> None:
        """Let the goal know what the robot was commanded."""
        if self._following is not None and self.recorded.velocities:
            self._following.was_commanded(self.recorded.velocities[-1][1])

    def _set_time(self, nanoseconds: int) -> None:
        for node in self._nodes:
            node.get_clock().set_ros_time_override(
                Time(nanoseconds=nanoseconds, clock_type=node.get_clock().clock_type)
            )

    def _hand_over(self, sample: Sample) -> None:
        at = self._goal.seconds(sample)
        if sample.topic == self._velocity_topic and sample.kind in CLASSES and at >= 0.0:
            message = _read(sample, CLASSES[sample.kind])
            if message is not None:
                twist = twist_of(message)
                self.recorded.velocities.append((at, Velocity(twist.linear.x, twist.angular.z, twist.linear.y)))
                self._follow()
        for subscription in [each for node in self._nodes for each in node.subscriptions]:
            if subscription.msg_type in NEEDED and self.recorded.error_code not in UNHEARD:
                self._listened.add(subscription.topic_name)
            if subscription.topic_name != sample.topic:
                continue
            self._heard.add(sample.topic)
            if (message := _read(sample, subscription.msg_type)) is None:
                self._unread[sample.topic] += 1
                continue
            with_info = len(inspect.signature(subscription.callback).parameters) > 1
            subscription.callback(message, *([{}] if with_info else []))
            if isinstance(message, Odometry) and 0.0 <= at <= self.recorded.ended_at:
                self.measured.append(at)

    def _follow_goal(self, goal: Goal) -> None:
        self._following = goal

    def _hear(self, now: float, step: Command | Outcome) -> None:
        at = now - self._goal.began_ns / NS
        self.replayed.ended_at = at
        if isinstance(step, Command):
            self.replayed.enter(at, step.stage.value)
            self.replayed.velocities.append((at, STANDSTILL if step.yields else step.velocity))
        elif not self.replayed.end:
            self.replayed.end = step.end.value
            self.replayed.error_code = "" if step.error_code.number == 0 else step.error_code.value
            self.replayed.error_msg = step.error_msg

    def close(self) -> None:
        """End the nodes."""
        for node in self._nodes:
            node.destroy_node()


def _memory(goal: RecordedGoal) -> DockMemory:
    """Return what the server knew from earlier goals, by its first report on this one; nothing without it."""
    for sample in goal.samples:
        for status in getattr(_read(sample, DiagnosticArray), "status", ()):
            values = {each.key: each.value for each in status.values}
            if values.get("goal_id") == goal.goal_id and "memory" in values:
                with suppress(Exception):  # whatever a made up recording brings about
                    return DockMemory.from_json(values["memory"]).shifted(goal.began_ns / NS)
    return DockMemory()


def _read(sample: Sample, kind: Any) -> Any:
    """Return a message; None if it is not one of the type, which no subscription would get."""
    if sample.kind != _type_name(kind):
        return None
    with suppress(Exception):  # whatever damaged bytes bring about
        return deserialize_message(sample.data, kind)
    return None


def _type_name(kind: Any) -> str:
    package, what, *_ = kind.__module__.split(".")
    return f"{package}/{what}/{kind.__name__}"


class _RunningClock:
    """The clock of a replay runs, however long this process waits for a processor."""

    stopped = False
    doubt = ""

    def begin(self) -> None:
        """Nothing is measured."""


class _WatchedAction:
    """An action whose goals tell what they decide."""

    def __init__(self, action: RobotAction[Any], hear: Hear, begin: Callable[[Goal], None]) -> None:
        self._action = action
        self._hear = hear
        self._begin = begin

    def __getattr__(self, name: str) -> Any:
        return getattr(self._action, name)

    def make_goal(self, *args: Any) -> Any:
        goal = self._action.make_goal(*args)
        self._begin(goal)
        return _WatchedGoal(goal, self._hear)


class _WatchedGoal:
    """A goal that tells what it decides. What detects the marker was switched on for the recorded goal."""

    def __init__(self, goal: Goal, hear: Hear) -> None:
        self._goal = goal
        self._hear = hear

    def __getattr__(self, name: str) -> Any:
        return getattr(self._goal, name)

    def detect_with(self, _: object) -> None:
        """Do without the service."""

    def step(self, observation: Observation) -> Command | Outcome:
        step = self._goal.step(observation)
        self._hear(observation.now, step)
        return step


class _Handle:
    """The recorded goal, as an action server hands it over."""

    def __init__(self, goal: RecordedGoal, action_type: Any) -> None:
        desired = goal.request.get("desired_battery_state")
        desired = desired if isinstance(desired, dict) else {}
        self.goal_id = UUID(uuid=list(goal.uuid))
        self.request = action_type.Goal()
        self.request.desired_battery_state.power_supply_status = int(desired.get("power_supply_status") or 0)
        self.request.desired_battery_state.location = str(desired.get("location") or "")

    def execute(self, _: object) -> None:
        """The control steps are done by `Replay`."""

    def publish_feedback(self, _: object) -> None:
        """There is no client that waits for it."""

    succeed = abort = canceled = lambda self: None
