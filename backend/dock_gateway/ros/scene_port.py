"""The topics with the poses of a robot and its dock. They are many and fast; subscribed to only while watched."""

import logging
import struct
import time
from collections.abc import Callable
from typing import Any, ClassVar

from geometry_msgs.msg import PolygonStamped, PoseStamped
from geometry_msgs.msg import Pose as RosPose
from nav_msgs.msg import Odometry
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import Range

from dock_gateway.core.event import moment, scene_event
from dock_gateway.core.footprint import footprint_document
from dock_gateway.core.scene import BASE, FOOTPRINT_FRAMES, ODOM, PLACED_FOR, WORLD, EvenRate, Pose, Scene, SeenPose
from dock_gateway.ros.listener import Handler
from dock_gateway.ros.messages.types import type_name
from dock_gateway.ros.typed_topics import TypedTopic, TypedTopics
from robot_io.qos import LATCHED

log = logging.getLogger(__name__)

# The stamp of a message, which its header begins with, in little-endian CDR.
STAMP, CDR_HEADER = struct.Struct("<iI"), 4

# The types of the topics.
TYPES = {
    Odometry: ("odom", "ground_truth"),
    PoseStamped: ("true_dock_pose", "detected_dock_pose", "filtered_dock_pose", "staging_pose"),
    PolygonStamped: ("footprint",),
    Range: ("infrared/left", "infrared/center", "infrared/right"),
}
SCENE_TYPES = {topic: type_name(kind) for kind, topics in TYPES.items() for topic in topics}

TRUTH, ODOMETRY, DOCK = "ground_truth", "odom", "true_dock_pose"

# Only the newest message counts.
LATEST = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT, durability=DurabilityPolicy.VOLATILE)
OnOdometry = Callable[[Odometry, dict[str, Any]], None]
OnPoses = Callable[[str, dict[str, Any], int], None]


class ScenePort:
    """Combines the topics of one robot into a scene on the listener's thread, and sends it to the loop.

    It is created and closed on the ROS thread.

    Args:
        topics: Joins the topics.
        namespace: Namespace of the robot.
        resolve: Makes a name absolute.
        on_scene: Called on the loop with an event, at most 20 times a second.
        stop_topic: The topic by whose endpoints gateways are known.
    """

    # Topic of a pose → its name in the scene.
    poses: ClassVar = {"detected_dock_pose": "marker", "filtered_dock_pose": "docked", "staging_pose": "staging"}
    receivers: ClassVar[tuple[str, ...]] = ("left", "center", "right")
    max_rate = 20.0  # Hz
    raw = False  # whether odometry is heard as bytes

    def __init__(
        self,
        topics: TypedTopics,
        namespace: str,
        resolve: Callable[[str], str],
        on_scene: Callable[..., None],
        *,
        stop_topic: str,
    ) -> None:
        self._bridge = topics.bridge
        self._namespace = namespace
        self._on_scene = on_scene
        self._scene = Scene()
        self._doubted: set[str] = set()  # topics whose poses were not used
        self._pace = EvenRate(self.max_rate)
        self._truth_at = time.monotonic()  # wait for ground truth before odometry alone is shown
        self._topics: list[TypedTopic] = []

        def listen(kind: type, name: str, callback: Callable[..., None], quality: QoSProfile, **options: Any) -> None:
            topic = topics.subscribe(resolve(name), kind, stop_topic, Handler(callback), quality, **options)
            self._topics.append(topic)

        # The true pose is read first: after a pause, odometry would be taken for all that there is.
        for name, hear in ((TRUTH, self._hear_truth), (ODOMETRY, self._hear_odometry)):
            listen(Odometry, name, self._reader(hear), LATEST, raw=self.raw)
        listen(PoseStamped, DOCK, self._hear_dock, LATCHED)
        listen(PolygonStamped, "footprint", self._hear_footprint, LATCHED)
        for topic, name in self.poses.items():
            listen(PoseStamped, topic, self._hear_pose(name, topic), LATEST)
        for name in self.receivers:
            listen(Range, f"infrared/{name}", self._hear_range(name), LATEST)

    def _reader(self, hear: OnOdometry) -> Callable[..., None]:
        """Return the function that is called with each message of odometry."""
        return hear

    def close(self) -> None:
        """Leave the topics."""
        for topic in self._topics:
            topic.close()

    def _hear_odometry(self, message: Odometry, info: dict[str, Any]) -> None:
        now = time.monotonic()
        if self._place(message, ODOM, now) and now - self._truth_at > PLACED_FOR:
            self._show(now, info)

    def _hear_truth(self, message: Odometry, info: dict[str, Any]) -> None:
        now = time.monotonic()
        if self._place(message, WORLD, now):
            self._truth_at = now
            self._show(now, info)

    def _read_pose(self, pose: RosPose, topic: str) -> Pose | None:
        """Return the pose in the plane; None if it cannot be right, which is logged once for each topic."""
        turn = pose.orientation
        try:
            return Pose.in_plane(pose.position.x, pose.position.y, (turn.x, turn.y, turn.z, turn.w))
        except ValueError as error:
            if topic not in self._doubted:
                self._doubted.add(topic)
                log.warning("poses on %s of %s are not used: %s", topic, self._namespace, error)
            return None

    def _place(self, message: Odometry, frame: str, now: float) -> bool:
        pose = self._read_pose(message.pose.pose, TRUTH if frame == WORLD else ODOMETRY)
        if pose is not None:
            self._scene.place(SeenPose(pose, frame, read_stamp(message), now))
        return pose is not None

    def _show(self, now: float, info: dict[str, Any]) -> None:
        if self._pace.due(now) and (document := self._scene.document(now)) is not None:
            self._tell(document, info["source_timestamp"])

    def _tell(self, document: dict[str, Any], source_ns: int) -> None:
        self._bridge.to_loop(self._on_scene, scene_event(document, moment(source_ns), robot=self._namespace))

    def _hear_dock(self, message: PoseStamped, _: dict[str, Any]) -> None:
        if message.header.frame_id in (WORLD, "") and (pose := self._read_pose(message.pose, DOCK)) is not None:
            self._scene.set_dock(pose)

    def _hear_footprint(self, message: PolygonStamped, _: dict[str, Any]) -> None:
        frame = message.header.frame_id.lstrip("/")
        try:
            if frame not in FOOTPRINT_FRAMES:
                raise ValueError(f"it is in the frame {frame}, not in {BASE}")
            self._scene.set_footprint(footprint_document([(point.x, point.y) for point in message.polygon.points]))
        except ValueError as error:
            log.warning("the footprint of %s is ignored: %s", self._namespace, error)

    def _hear_pose(self, name: str, topic: str) -> Callable[[PoseStamped, dict[str, Any]], None]:
        def hear(message: PoseStamped, _: dict[str, Any]) -> None:
            if (pose := self._read_pose(message.pose, topic)) is not None:
                frame = message.header.frame_id.lstrip("/")
                self._scene.say(name, SeenPose(pose, frame, read_stamp(message), time.monotonic()))

        return hear

    def _hear_range(self, name: str) -> Callable[[Range, dict[str, Any]], None]:
        def hear(message: Range, _: dict[str, Any]) -> None:
            self._scene.set_range(name, message.range, time.monotonic())

        return hear


class PosePort(ScenePort):
    """The part of a scene that is stored while a goal runs: without what the robot's sensors see.

    Args as for `ScenePort`, but `on_scene` is an `OnPoses`: called with the robot, the scene and the time (ns).
    """

    poses: ClassVar = {"filtered_dock_pose": "docked", "staging_pose": "staging"}
    receivers: ClassVar[tuple[str, ...]] = ()
    max_rate = 10.0
    raw = True
    slot_ns = 100_000_000

    def _reader(self, hear: OnOdometry) -> Callable[..., None]:
        """Decode one message in each slot: decoding is what odometry costs.

        They are chosen by their stamps, so that those of both topics belong together.
        """
        last = -1

        def hear_some(raw: bytes, info: dict[str, Any]) -> None:
            nonlocal last
            seconds, nanoseconds = STAMP.unpack_from(raw, CDR_HEADER) if raw[1] & 1 else (0, 0)
            slot = (seconds * 10**9 + nanoseconds or time.time_ns()) // self.slot_ns
            if slot != last:
                last = slot
                hear(deserialize_message(raw, Odometry), info)

        return hear_some

    def _tell(self, document: dict[str, Any], source_ns: int) -> None:
        self._bridge.to_loop(self._on_scene, self._namespace, document, source_ns)


class MapPort(PosePort):
    """The part of a scene that is on the map of all robots: where a robot and its dock are. Args as for `PosePort`."""

    poses: ClassVar = {}
    slot_ns = 200_000_000


def read_stamp(message: Any) -> float:
    """Return the stamp of a message's header, in seconds."""
    stamp = message.header.stamp
    return int(stamp.sec) + int(stamp.nanosec) / 1e9
