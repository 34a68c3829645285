"""A server of nav2's `navigate_to_pose` that drives the simulated robot, in the test process."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from geometry_msgs.msg import TransformStamped, Twist, Vector3
from nav2_msgs.action import NavigateToPose
from nav_msgs.msg import Odometry
from rclpy.node import Node

from docking.behaviors.moves import drive_to, turn
from docking.core.geometry import Pose, normalize_angle
from docking.core.observation import STANDSTILL, Velocity
from docking.core.transform import spatial
from docking.parameters import MotionLimits
from docking.ros.geometry import pose_from, transform_message
from docking.ros.process import Spinner
from robot_io.qos import LATCHED
from tests.support.docking_servers import Server
from tests.support.observer import ros_nodes
from tests.support.waiting import PATIENCE
from tf2_msgs.msg import TFMessage

MOTION = MotionLimits(v_linear_max=0.8, a_linear_max=1.5)
MARK = 1.0
"""linear.z of its motions, which no robot on wheels looks at; that of its zero velocity is -0.0. Others publish 0.0."""
NO_VALID_PATH = 208
LONGEST = 120.0


class Nav2(Server):
    """Drives by the simulator's ground truth, and publishes the map: its frame `map` is the simulator's world.

    Attributes:
        poses: Those of the goals, with their frames.
        driving: Whether a goal runs.
        asked: How many goals have come.
        answers: While it is not set, no goal is answered.
        rejects: Whether it rejects goals.
        gives_up: Whether it aborts goals as soon as the robot moves.
        trees: Their behavior trees.
        ends: How the goals have ended.
    """

    def __init__(self, node: Node, start: Pose) -> None:
        super().__init__(node)
        self.poses: list[tuple[str, Pose]] = []
        self.trees: list[str] = []
        self.ends: list[str] = []
        self.driving = self.rejects = self.gives_up = False
        self.asked = 0
        self.answers = threading.Event()
        self.answers.set()
        self._start = start
        self._robot: Pose | None = None
        self._wheels = node.create_publisher(Twist, "cmd_vel", 10)
        node.create_subscription(Odometry, "ground_truth", self._take_truth, 10)
        self.server = self.serve(NavigateToPose, "navigate_to_pose", self.navigate, self._accepts)
        odom = TransformStamped(child_frame_id="odom", transform=transform_message(spatial(start)))
        odom.header.frame_id = "map"
        self._fixed = node.create_publisher(TFMessage, "tf_static", LATCHED)
        self._fixed.publish(TFMessage(transforms=[odom]))

    def _accepts(self) -> bool:
        self.asked += 1
        self.answers.wait(LONGEST)
        return not self.rejects

    def _take_truth(self, message: Odometry) -> None:
        self._robot = pose_from(message.pose.pose)

    def _go(self, velocity: Velocity) -> None:
        linear = Vector3(x=velocity.linear_x, z=-0.0 if velocity == STANDSTILL else MARK)
        self._wheels.publish(Twist(linear=linear, angular=Vector3(z=velocity.angular_z)))

    async def navigate(self, handle: Any) -> Any:
        target = pose_from(handle.request.pose.pose)
        frame = handle.request.pose.header.frame_id
        self.poses.append((frame, target))
        self.trees.append(handle.request.behavior_tree)
        if frame == "odom":
            target = self._start.compose(target)
        result = NavigateToPose.Result()
        self.driving, moved = True, 0
        async for _ in self.steps(LONGEST):
            velocity = STANDSTILL if self._robot is None else _towards(self._robot, target)
            if handle.is_cancel_requested:
                self._end(handle.canceled, "canceled")
                return result
            if self.gives_up and moved > 5:
                result.error_code, result.error_msg = NO_VALID_PATH, "no valid path found"
                self._end(handle.abort, "aborted")
                return result
            if self._robot is not None and velocity == STANDSTILL:
                break
            self._go(velocity)
            moved += 1
            handle.publish_feedback(NavigateToPose.Feedback())
        self._end(handle.succeed, "succeeded")
        return result

    def _end(self, end: Any, how: str) -> None:
        self._go(STANDSTILL)
        self.driving = False
        self.ends.append(how)
        end()


def _towards(robot: Pose, target: Pose) -> Velocity:
    if robot.distance_to(target) > 0.15:
        return drive_to(robot, target, MOTION)
    error = normalize_angle(target.theta - robot.theta)
    return turn(error, MOTION) if abs(error) > 0.1 else STANDSTILL


@contextmanager
def nav2(domain: int, start: Pose) -> Iterator[Nav2]:
    """The server in the test process.

    Args:
        domain: The ROS domain.
        start: Where the simulator was started, in its world: the origin of odometry.
    """
    with ros_nodes(domain) as context:
        node = Node("bt_navigator", context=context)
        server = Nav2(node, start)
        with Spinner(context, [node]) as spinner:
            try:
                yield server
            finally:
                spinner.call(server.server.destroy).result(PATIENCE)  # which rclpy would leave on the ROS graph
        assert spinner.failure is None
