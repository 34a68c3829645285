"""The topics with the poses of a robot and its dock. They are many and fast; subscribed to only while watched."""

import math
import time
from collections.abc import Callable
from typing import Any

from geometry_msgs.msg import Pose as RosPose
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.subscription import Subscription
from sensor_msgs.msg import Range

from dock_gateway.core.event import Event, moment, scene_event
from dock_gateway.core.scene import ODOM, PLACED_FOR, WORLD, Pace, Pose, Scene, Seen
from dock_gateway.ros.bridge import Bridge, guard
from dock_gateway.ros.robot_ports import LATCHED

# Only the newest message counts.
LATEST = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT, durability=DurabilityPolicy.VOLATILE)
MAX_RATE = 20.0  # Hz

# Topic of a pose → its name in the scene.
POSES = {"detected_dock_pose": "marker", "filtered_dock_pose": "docked", "staging_pose": "staging"}
RECEIVERS = ("left", "center", "right")

OnScene = Callable[[Event], None]


class ScenePort:
    """Combines the topics of one robot into a scene on the listener's thread, and sends it to the loop.

    It is created and closed on the ROS thread.

    Args:
        bridge: The bridge to the ROS thread.
        namespace: Namespace of the robot.
        resolve: Makes a name absolute.
        on_scene: Called on the loop with an event, at most 20 times a second.
    """

    def __init__(self, bridge: Bridge, namespace: str, resolve: Callable[[str], str], on_scene: OnScene) -> None:
        self._bridge = bridge
        self._namespace = namespace
        self._on_scene = on_scene
        self._scene = Scene()
        self._pace = Pace(MAX_RATE)
        self._truth_at = time.monotonic()  # wait for ground truth before odometry alone is shown
        listen = bridge.node.create_subscription
        self._subscriptions: list[Subscription] = [
            listen(Odometry, resolve("odom"), guard(self._hear_odometry), LATEST),
            listen(Odometry, resolve("ground_truth"), guard(self._hear_truth), LATEST),
            listen(PoseStamped, resolve("true_dock_pose"), guard(self._hear_dock), LATCHED),
            *(
                listen(PoseStamped, resolve(topic), guard(self._hear_pose(name)), LATEST)
                for topic, name in POSES.items()
            ),
            *(listen(Range, resolve(f"infrared/{name}"), guard(self._hear_range(name)), LATEST) for name in RECEIVERS),
        ]

    def close(self) -> None:
        """Leave the topics."""
        for subscription in self._subscriptions:
            self._bridge.node.destroy_subscription(subscription)

    def _hear_odometry(self, message: Odometry, info: dict[str, Any]) -> None:
        now = time.monotonic()
        if self._place(message, ODOM, now) and now - self._truth_at > PLACED_FOR:
            self._show(now, info)

    def _hear_truth(self, message: Odometry, info: dict[str, Any]) -> None:
        now = time.monotonic()
        if self._place(message, WORLD, now):
            self._truth_at = now
            self._show(now, info)

    def _place(self, message: Odometry, frame: str, now: float) -> bool:
        pose = read_pose(message.pose.pose)
        if pose is not None:
            self._scene.place(Seen(pose, frame, read_stamp(message), now))
        return pose is not None

    def _show(self, now: float, info: dict[str, Any]) -> None:
        if self._pace.due(now) and (document := self._scene.document(now)) is not None:
            event = scene_event(document, moment(info["source_timestamp"]), robot=self._namespace)
            self._bridge.to_loop(self._on_scene, event)

    def _hear_dock(self, message: PoseStamped, _: dict[str, Any]) -> None:
        if message.header.frame_id in (WORLD, "") and (pose := read_pose(message.pose)) is not None:
            self._scene.set_dock(pose)

    def _hear_pose(self, name: str) -> Callable[[PoseStamped, dict[str, Any]], None]:
        def hear(message: PoseStamped, _: dict[str, Any]) -> None:
            if (pose := read_pose(message.pose)) is not None:
                frame = message.header.frame_id.lstrip("/")
                self._scene.say(name, Seen(pose, frame, read_stamp(message), time.monotonic()))

        return hear

    def _hear_range(self, name: str) -> Callable[[Range, dict[str, Any]], None]:
        def hear(message: Range, _: dict[str, Any]) -> None:
            self._scene.set_range(name, message.range, time.monotonic())

        return hear


def read_pose(pose: RosPose) -> Pose | None:
    """Return the pose in the plane, None if it is not finite."""
    turn = pose.orientation
    theta = math.atan2(2 * (turn.w * turn.z + turn.x * turn.y), turn.w**2 + turn.x**2 - turn.y**2 - turn.z**2)
    found = Pose(pose.position.x, pose.position.y, theta)
    return found if found.finite else None


def read_stamp(message: Any) -> float:
    """Return the stamp of a message's header, in seconds."""
    stamp = message.header.stamp
    return int(stamp.sec) + int(stamp.nanosec) / 1e9
