"""The poses that a docking goal is about, for whoever wants to see them; the names are nav2's."""

from geometry_msgs.msg import PoseStamped
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos_overriding_options import QoSOverridingOptions

from docking.goal.outcome import Command
from docking.ros.geometry import stamped_pose

TOPICS = ("dock_pose", "filtered_dock_pose", "staging_pose")


class PosePublishers:
    """Publishers of `dock_pose`, `filtered_dock_pose` and `staging_pose`, while they are wanted."""

    def __init__(self, node: Node) -> None:
        """Start without publishers.

        Args:
            node: The node that publishes. All calls must come from the thread that spins it.
        """
        self._node = node
        self._publishers: dict[str, Publisher] = {}

    def switch(self, *, on: bool) -> None:
        """Make the publishers, or take them back."""
        if on and not self._publishers:
            qos = QoSOverridingOptions.with_default_policies()
            for topic in TOPICS:
                self._publishers[topic] = self._node.create_publisher(
                    PoseStamped, topic, 10, qos_overriding_options=qos
                )
        elif not on:
            while self._publishers:
                self._node.destroy_publisher(self._publishers.popitem()[1])

    def publish(self, command: Command, frame: str) -> None:
        """Publish the poses that are known.

        Args:
            command: What holds them.
            frame: The frame they are given in, that of odometry.
        """
        known = zip(TOPICS, (command.dock_pose, command.filtered_dock_pose, command.staging_pose), strict=True)
        for topic, pose in known:
            if pose is not None and topic in self._publishers:
                self._publishers[topic].publish(stamped_pose(pose, frame, self._node.get_clock().now().to_msg()))
