"""The action `navigate_to_pose` of the simulated robot, where nav2_msgs is installed: a small stand-in for nav2."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from random import Random
from typing import Any

from builtin_interfaces.msg import Duration, Time
from nav_msgs.msg import Path
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.node import Node
from rclpy.task import Future

from docking.core.geometry import Pose
from docking.core.observation import STANDSTILL
from docking.goal.outcome import End
from docking.ros.geometry import path_message, pose_from, stamped_pose
from docking.ros.navigation import ACTION, NavigateToPose
from docking.ros.simulator_messages import BASE, MAP, ODOM, WORLD
from docking.simulation.ride import MOTION, Ride
from docking.simulation.route import NoWayError, Point, Routes
from docking.simulation.simulation import Simulation
from robot_io.endpoints import overridable_publisher

NO_VALID_PATH = 208
"""nav2's error_code of its planner."""
FEEDBACK_PERIOD = 0.1
"""Simulated seconds."""
PLAN_PERIOD = 1.0
"""The same."""
PATIENCE = 1.0, 3.0
"""Seconds that a robot waits for another one before it drives around it."""
RESULT_TIMEOUT = 60
"""Seconds for which results are kept."""


@dataclass(eq=False)
class _Goal:
    """A goal that was accepted.

    Attributes:
        handle: rclpy's.
        ride: How the robot gets there.
        started_at: Simulated seconds.
        ended: How it ends, and why.
        feedback_due: When to publish feedback, in simulated seconds.
        plan_due: The same for the plan.
    """

    handle: ServerGoalHandle
    ride: Ride
    started_at: float
    ended: Future
    feedback_due: float = 0.0
    plan_due: float = 0.0


class SimulatorNavigation:
    """Drives the simulated robot to poses on its map. All calls must come from the thread that spins the node.

    It commands the wheels directly, and publishes `plan`: the way that is ahead, and an empty one at the end.
    """

    def __init__(self, node: Node, routes: Routes, simulation: Callable[[], Simulation]) -> None:
        """Offer the action.

        Args:
            node: The simulator.
            routes: On the map.
            simulation: The current one.
        """
        self._node = node
        self._routes = routes
        self._simulation = simulation
        self._goal: _Goal | None = None
        # Robots that wait for each other do not begin to drive around each other at once.
        self._patience = Random(node.get_namespace()).uniform(*PATIENCE)  # noqa: S311 - no secret
        self._plan = overridable_publisher(node, Path, "plan", 1)
        self._server = ActionServer(
            node,
            NavigateToPose,
            ACTION,
            execute_callback=partial(self._execute, Future()),  # each goal gets its own
            goal_callback=self._decide,
            handle_accepted_callback=self._accept,
            cancel_callback=self._cancel,
            result_timeout=RESULT_TIMEOUT,
        )

    def close(self) -> None:
        """Leave the ROS graph, which rclpy does not do by itself."""
        self._server.destroy()

    @property
    def drives(self) -> bool:
        """Whether a goal runs."""
        return self._goal is not None

    def step(self) -> None:
        """Command the next velocity, while a goal runs."""
        goal, simulation = self._goal, self._simulation()
        if goal is None:
            return
        try:
            robot, now = simulation.robot.pose, simulation.time
            velocity = goal.ride.step(robot, simulation.fixed_obstacles, now, simulation.others)
        except NoWayError as error:
            self.abort(str(error))
            return
        if velocity is None:
            self._end(End.SUCCEEDED)
            return
        simulation.robot.command(velocity)
        self._tell(goal, simulation)

    def abort(self, reason: str) -> None:
        """Stop the robot and abort the goal, if one runs.

        Args:
            reason: Why, as a sentence.
        """
        self._end(End.ABORTED, reason)

    # A goal comes, is canceled, ends.

    def _decide(self, request: Any) -> GoalResponse:
        reason = "a stop is latched" if self._simulation().halted else ""
        try:
            self._target(request.pose)
        except ValueError as error:
            reason = f"its pose {error}"
        if not reason:
            return GoalResponse.ACCEPT
        self._node.get_logger().warning(f"A goal of {ACTION} is rejected: {reason}")
        return GoalResponse.REJECT

    def _target(self, message: Any) -> Pose:
        """The pose of a goal in world.

        Raises:
            ValueError: It is none, or its frame is unknown.
        """
        pose, frame, simulation = pose_from(message.pose), message.header.frame_id, self._simulation()
        if frame in {MAP, WORLD, ""}:
            return pose
        if frame == BASE:
            return simulation.robot.pose.compose(pose)
        if frame == ODOM:
            return simulation.odometry_origin.compose(pose)
        raise ValueError(f"is in the frame {frame!r}, but must be in {MAP}, {WORLD}, {ODOM} or {BASE}")

    def _accept(self, handle: ServerGoalHandle) -> None:
        self.abort("another goal came")
        ended, simulation = Future(), self._simulation()
        handle.execute(partial(self._execute, ended))
        robot = simulation.robot
        try:
            target = self._target(handle.request.pose)
            ride = Ride(self._routes, robot.pose, target, robot.radius, simulation.time, patience=self._patience)
        except NoWayError as error:
            ended.set_result((End.ABORTED, str(error)))
            return
        self._goal = _Goal(handle, ride, simulation.time, ended)
        self._tell(self._goal, simulation)

    def _cancel(self, handle: ServerGoalHandle) -> CancelResponse:
        if self._goal is None or self._goal.handle.goal_id != handle.goal_id:
            return CancelResponse.REJECT  # it has ended already
        self._end(End.CANCELED)
        return CancelResponse.ACCEPT

    def _end(self, end: End, reason: str = "") -> None:
        goal, self._goal = self._goal, None
        if goal is None:
            return
        self._simulation().robot.command(STANDSTILL)
        self._plan.publish(self._path([], 0.0))
        goal.ended.set_result((end, reason))

    async def _execute(self, ended: Future, handle: ServerGoalHandle) -> Any:
        end, reason = await ended
        {End.SUCCEEDED: handle.succeed, End.CANCELED: handle.canceled, End.ABORTED: handle.abort}[end]()
        result = NavigateToPose.Result()
        if end is End.ABORTED:
            self._node.get_logger().warning(f"A goal of {ACTION} is aborted: {reason}")
            for name, value in (("error_code", NO_VALID_PATH), ("error_msg", reason)):
                if hasattr(result, name):  # older versions of nav2 have neither
                    setattr(result, name, value)
        return result

    # What others see of it.

    def _tell(self, goal: _Goal, simulation: Simulation) -> None:
        """Publish feedback and the plan, each in its time."""
        now, robot = simulation.time, simulation.robot.pose
        if now >= goal.plan_due:
            goal.plan_due = now + PLAN_PERIOD
            self._plan.publish(self._path([(robot.x, robot.y), *goal.ride.way], goal.ride.target.theta))
        if now >= goal.feedback_due:
            goal.feedback_due = now + FEEDBACK_PERIOD
            remaining = goal.ride.remaining(robot)
            goal.handle.publish_feedback(
                NavigateToPose.Feedback(
                    current_pose=stamped_pose(robot, MAP, self._now()),
                    navigation_time=_duration(now - goal.started_at),
                    estimated_time_remaining=_duration(remaining / MOTION.v_linear_max),
                    distance_remaining=remaining,
                )
            )

    def _path(self, points: Sequence[Point], heading: float) -> Path:
        headings = [math.atan2(end[1] - start[1], end[0] - start[0]) for start, end in pairwise(points)]
        poses = [Pose(x, y, theta) for (x, y), theta in zip(points, [*headings, heading], strict=False)]
        return path_message(poses, MAP, self._now())

    def _now(self) -> Time:
        return self._node.get_clock().now().to_msg()


def _duration(seconds: float) -> Duration:
    whole = math.floor(seconds)
    return Duration(sec=whole, nanosec=int(1e9 * (seconds - whole)))
