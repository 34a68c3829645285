"""Replays a recorded goal to an action server: with its own clock, at once, and without moving anything.

The server is the real one with its subscriptions, in a process that nobody discovers. It is not spun: each recorded
message is handed to the callbacks of its topic, and the control steps come when they would have come.
"""

import inspect
from collections.abc import Callable
from typing import Any, cast

from rclpy.context import Context
from rclpy.node import Node
from rclpy.serialization import deserialize_message
from rclpy.time import Time
from unique_identifier_msgs.msg import UUID

from docking.core.battery import Battery
from docking.core.observation import STANDSTILL, Observation, Velocity
from docking.goal.engine import Goal
from docking.goal.outcome import Command, Outcome
from docking.replay.course import Course
from docking.replay.recorded_goal import NS, RecordedGoal
from docking.ros.battery_subscriber import BatteryStateSubscriber
from docking.ros.node import ActionNode
from docking.ros.robot_action import RobotAction
from robot_io.recording import Sample
from robot_io.velocity import CLASSES

AFTER = 5.0
"""Seconds after the recorded end in which the goal may still end."""
Hear = Callable[[float, Command | Outcome], None]


class Replay:
    """One goal, replayed.

    Attributes:
        recorded: What was recorded, with its velocities.
        replayed: What became of the goal now.
    """

    def __init__(self, goal: RecordedGoal, action: RobotAction[Any], context: Context) -> None:
        """Make the action server.

        Args:
            goal: The recorded goal.
            action: Its action.
            context: The ROS context, with the robot's parameters and `use_sim_time`.

        Raises:
            ValueError: The goal cannot be replayed; the error says why, as a sentence.
        """
        self.recorded = goal.course
        self.replayed = Course()
        self._goal = goal
        battery = Battery()
        watched = cast("RobotAction[Any]", _WatchedAction(action, self._hear))
        self._server: ActionNode[Any] = ActionNode(watched, battery, context=context)
        self._nodes: tuple[Node, ...] = (self._server, BatteryStateSubscriber(battery, context=context))
        if self._server.settings.navigates:
            raise ValueError("nav2 drives this robot to its staging pose, which cannot be replayed")
        self._velocity_topic = self._server.resolve_topic_name("cmd_vel")

    def run(self) -> None:
        """Replay the goal to its end."""
        due: int | None = None
        period = round(self._server.settings.control_period * NS)
        for sample in self._goal.samples:
            if due is None and sample.received_ns >= self._goal.began_ns:
                self._set_time(self._goal.began_ns)
                self._server.accept(_Handle(self._goal, self._server.action_type))
                due = self._goal.began_ns
            # A recorded velocity tells when there was a control step.
            stepped = sample.topic == self._velocity_topic
            while due is not None and due <= sample.received_ns - (period // 2 if stepped else 0):
                self._set_time(due)
                self._server.control()
                due += period
            self._set_time(sample.received_ns)
            if due is not None and stepped:
                self._server.control()
                due = sample.received_ns + period
            self._hand_over(sample)
            if self.replayed.end:
                return
            if self.recorded.end and self._goal.seconds(sample) > self.recorded.ended_at + AFTER:
                return

    def _set_time(self, nanoseconds: int) -> None:
        for node in self._nodes:
            node.get_clock().set_ros_time_override(
                Time(nanoseconds=nanoseconds, clock_type=node.get_clock().clock_type)
            )

    def _hand_over(self, sample: Sample) -> None:
        at = self._goal.seconds(sample)
        if sample.topic == self._velocity_topic and sample.kind in CLASSES and at >= 0.0:
            message = deserialize_message(sample.data, CLASSES[sample.kind])
            twist = getattr(message, "twist", message)
            self.recorded.velocities.append((at, Velocity(twist.linear.x, twist.angular.z)))
        for node in self._nodes:
            for subscription in list(node.subscriptions):
                if subscription.topic_name == sample.topic:
                    message = deserialize_message(sample.data, subscription.msg_type)
                    with_info = len(inspect.signature(subscription.callback).parameters) > 1
                    subscription.callback(message, *([{}] if with_info else []))

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


class _WatchedAction:
    """An action whose goals tell what they decide."""

    def __init__(self, action: RobotAction[Any], hear: Hear) -> None:
        self._action = action
        self._hear = hear

    def __getattr__(self, name: str) -> Any:
        return getattr(self._action, name)

    def make_goal(self, *args: Any) -> Any:
        return _WatchedGoal(self._action.make_goal(*args), self._hear)


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
        desired = goal.request.get("desired_battery_state", {})
        self.goal_id = UUID(uuid=list(bytes.fromhex(goal.goal_id.replace("-", ""))))
        self.request = action_type.Goal()
        self.request.desired_battery_state.power_supply_status = int(desired.get("power_supply_status") or 0)
        self.request.desired_battery_state.location = str(desired.get("location") or "")

    def execute(self, _: object) -> None:
        """The control steps are done by `Replay`."""

    def publish_feedback(self, _: object) -> None:
        """Nobody waits for it."""

    succeed = abort = canceled = lambda self: None
