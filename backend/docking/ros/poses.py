"""The poses that a docking goal is about, and the way to them, for whoever wants to see them; the names are nav2's."""

import time

from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Path
from rclpy.node import Node
from rclpy.publisher import Publisher

from docking.core.errors import Stage
from docking.core.geometry import Pose
from docking.goal.outcome import Command
from docking.ros.geometry import path_message, stamped_pose
from robot_io.endpoints import overridable_publisher

TOPICS = ("dock_pose", "filtered_dock_pose", "staging_pose")
PLAN = "plan"
PLAN_PERIOD = 0.5
"""Seconds between two plans."""


class PosePublishers:
    """Publishers of `dock_pose`, `filtered_dock_pose`, `staging_pose` and `plan`, while they are wanted."""

    def __init__(self, node: Node) -> None:
        """Start without publishers.

        Args:
            node: The node that publishes. All calls must come from the thread that spins it.
        """
        self._node = node
        self._publishers: dict[str, Publisher] = {}
        self._planned_at = -PLAN_PERIOD
        self._frame = ""  # of the plan that was published last; empty after a goal

    def switch(self, *, on: bool) -> None:
        """Make the publishers, or take them back."""
        if on and not self._publishers:
            for topic in (*TOPICS, PLAN):
                kind = Path if topic == PLAN else PoseStamped
                self._publishers[topic] = overridable_publisher(self._node, kind, topic)
        elif not on:
            while self._publishers:
                self._node.destroy_publisher(self._publishers.popitem()[1])

    def publish(self, command: Command, frame: str, robot: Pose | None) -> None:
        """Publish the poses that are known, and now and then the way that is ahead.

        Args:
            command: What holds them.
            frame: The frame they are given in, that of odometry.
            robot: Where the robot is in it.
        """
        known = zip(TOPICS, (command.dock_pose, command.filtered_dock_pose, command.staging_pose), strict=True)
        for topic, pose in known:
            if pose is not None and topic in self._publishers:
                self._publishers[topic].publish(stamped_pose(pose, frame, self._node.get_clock().now().to_msg()))
        way, now = _way(command), time.monotonic()
        if way and robot is not None and now - self._planned_at >= PLAN_PERIOD:
            self._planned_at, self._frame = now, frame
            self._publish_plan([robot, *way])

    def end(self) -> None:
        """Publish an empty plan if there was one: the goal has ended."""
        if self._frame:
            self._publish_plan([])
            self._frame = ""

    def _publish_plan(self, poses: list[Pose]) -> None:
        if PLAN in self._publishers:
            self._publishers[PLAN].publish(path_message(poses, self._frame, self._node.get_clock().now().to_msg()))


def _way(command: Command) -> list[Pose]:
    """Return the known way of the robot; nothing while another server drives it."""
    docked, staging = command.filtered_dock_pose, command.staging_pose
    if command.yields or docked is None:
        return []
    if command.stage is Stage.CONTROLLING:
        return [docked]
    return [staging, docked] if command.stage is Stage.NAV_TO_STAGING_POSE and staging is not None else []
