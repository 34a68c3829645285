"""Subscribes to the robot's sensors, and returns their readings as the observation for goals and controllers."""

import enum
import math
from collections.abc import Callable
from functools import partial
from typing import Any

from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped
from nav_msgs.msg import Odometry as OdometryMessage
from rclpy.node import Node
from rclpy.qos_overriding_options import QoSOverridingOptions
from rclpy.subscription import Subscription
from sensor_msgs.msg import JointState, LaserScan, Range

from docking.core.battery import BatteryReading
from docking.core.geometry import Pose
from docking.core.observation import InfraredReading, Joint, MarkerDetection, Observation, Odometry, Scan, Velocity
from docking.core.transform import place, pose_of, spatial
from docking.estimation.track import Track
from docking.parameters import DockPlace
from docking.ros import localization
from docking.ros.clock import control_time
from docking.ros.geometry import pose_from, seconds_of, transform_from
from docking.ros.localization import LocalizationState
from docking.ros.transforms import Transforms
from robot_io.laser import flatten, points_of
from robot_io.qos import LATEST, volatile
from robot_io.reception import arrived_at
from robot_io.transform import Transform

MARKER_TOPIC = "detected_dock_pose"
RECEIVERS = ("left", "center", "right")
# Seconds. ROS finds the publishers of topics one after the other: a marker may be received this long before odometry or
# the transforms that it needs.
DISCOVERY = 1.0
MOST_MARKERS = 8
"""Detections between two observations that are kept: several tags may be on one topic."""


class Sensor(enum.Enum):
    """The sensors that can be listened to."""

    ODOMETRY = "odometry"
    MARKER = "marker"
    INFRARED = "infrared"
    SCAN = "scan"
    JOINTS = "joints"
    LOCALIZATION = "localization"


class Sensors:
    """Subscribes a node to some sensors and keeps what they said last.

    Attributes:
        odometry_frame: The frame that odometry is given in; empty before the first message.
        scanner: Where the laser scanner is, in base_link; None where tf says it.
        faults: The fault of the last message on each topic that has one, as sentences.
        place: Where the database has the goal's dock; None where it does not.
        joint_names: The joints that tell whether the wheels stall.
        marker_tilt: The marker's frame, x into the dock and z up, as seen from that of its detections.
    """

    def __init__(self, node: Node, transforms: Transforms, on_change: Callable[[], None]) -> None:
        """Start without any sensor.

        Args:
            node: The node that subscribes. All calls must come from the thread that spins it.
            transforms: How frames lie in each other.
            on_change: Called when `faults` have changed.
        """
        self.odometry_frame = ""
        self.scanner: Pose | None = Pose()
        self.faults: dict[str, str] = {}
        self.place: DockPlace | None = None
        self.joint_names: frozenset[str] = frozenset()
        self.marker_tilt = Transform()
        self._node = node
        self._transforms = transforms
        self._on_change = on_change
        self._base_frame = ""
        self._subscriptions: dict[Sensor, list[Subscription]] = {}
        self._track = Track()
        self._markers: list[MarkerDetection] = []  # since the last observation, and the one before
        self._unrelated_since: float | None = None  # markers come, and cannot be placed
        self._doubt = ""  # why not
        self._localization = LocalizationState()
        self._scan: Scan | None = None
        self._joints: dict[str, Joint] = {}
        self._ranges: dict[str, tuple[float, float]] = {}  # in m, and when it was received

    @property
    def odometry(self) -> Odometry | None:
        """The newest odometry; None where there is none."""
        return self._track.latest

    def listen_to(self, sensors: frozenset[Sensor], *, only_known: bool = False) -> None:
        """Subscribe to these sensors, and to no others any longer.

        Args:
            sensors: The sensors.
            only_known: Whether those that are not subscribed to are left out.
        """
        if only_known:
            sensors &= self._subscriptions.keys()
            self.place = None
        for sensor in self._subscriptions.keys() - sensors:
            for subscription in self._subscriptions.pop(sensor):
                self._set_fault(subscription.topic_name, None)
                self._node.destroy_subscription(subscription)
            self._forget(sensor)
        for sensor in sensors - self._subscriptions.keys():
            self._subscriptions[sensor] = self._subscribe(sensor)
        located = bool(sensors) and self.place is not None
        by_frames = located or Sensor.MARKER in sensors or (Sensor.SCAN in sensors and self.scanner is None)
        self._transforms.use(self, on=by_frames)

    def _subscribe(self, sensor: Sensor) -> list[Subscription]:
        if sensor is Sensor.ODOMETRY:
            return [self._subscription(OdometryMessage, "odom", self._take_odometry)]
        if sensor is Sensor.MARKER:
            return [self._subscription(PoseStamped, MARKER_TOPIC, self._take_marker)]
        if sensor is Sensor.SCAN:
            return [self._subscription(LaserScan, "scan", self._take_scan)]
        if sensor is Sensor.JOINTS:
            return [self._subscription(JointState, "joint_states", self._take_joints)]
        if sensor is Sensor.LOCALIZATION:
            return [self._subscription(PoseWithCovarianceStamped, localization.TOPIC, self._localization.take)]
        return [self._subscription(Range, f"infrared/{name}", partial(self._take_range, name)) for name in RECEIVERS]

    def _subscription(self, message_type: type, topic: str, take: Callable[[Any, float], None]) -> Subscription:
        resolved = self._node.resolve_topic_name(topic)

        def receive(message: Any, info: dict[str, Any]) -> None:
            try:
                take(message, arrived_at(info, control_time(self._node)))
            except ValueError as error:
                self._set_fault(resolved, f"{resolved} {error}")
            else:
                self._set_fault(resolved, None)

        return self._node.create_subscription(
            message_type,
            topic,
            receive,
            LATEST if message_type is not PoseStamped else volatile(MOST_MARKERS),
            qos_overriding_options=QoSOverridingOptions.with_default_policies(),
        )

    def _forget(self, sensor: Sensor) -> None:
        if sensor is Sensor.ODOMETRY:
            self._track.clear()
        elif sensor is Sensor.MARKER:
            self._markers, self._unrelated_since = [], None
        elif sensor is Sensor.SCAN:
            self._scan = None
        elif sensor is Sensor.JOINTS:
            self._joints = {}
        elif sensor is Sensor.LOCALIZATION:
            self._localization.error = math.nan
        else:
            self._ranges.clear()

    def _set_fault(self, topic: str, fault: str | None) -> None:
        if self.faults.get(topic) == fault:
            return
        if fault is None:
            del self.faults[topic]
        else:
            self.faults[topic] = fault
            self._node.get_logger().error(fault, throttle_duration_sec=1.0)
        self._on_change()

    # Messages come in.

    def _take_odometry(self, message: OdometryMessage, received: float) -> None:
        twist = message.twist.twist
        velocity = Velocity(twist.linear.x, twist.angular.z, twist.linear.y)
        pose = pose_from(message.pose.pose)
        if not velocity.finite:
            raise ValueError("has a velocity that is not a number")
        self.odometry_frame = self._transforms.frame(message.header.frame_id)
        self._base_frame = self._transforms.frame(message.child_frame_id)
        measured_at = seconds_of(message.header.stamp)
        if measured_at == 0.0:  # never set: what else is stamped is compared with the moment of arrival
            measured_at = seconds_of(self._node.get_clock().now().to_msg())
        self._track.add(measured_at, Odometry(pose, velocity, received))

    def _take_marker(self, message: PoseStamped, received: float) -> None:
        seen = transform_from(message.pose.position, message.pose.orientation)
        measured_at = seconds_of(message.header.stamp)
        try:
            if self._track.latest is None:
                raise ValueError("cannot be used: no odometry has come yet")
            frame, lies = self._locate(self._transforms.frame(message.header.frame_id), measured_at)
        except ValueError as error:
            if self._unrelated_since is None:
                self._unrelated_since = received
            self._doubt = str(error)
            if received - self._unrelated_since < DISCOVERY:
                return
            raise
        self._unrelated_since = None
        odometry = self._odometry_at(measured_at)
        pose = pose_of(lies.compose(seen).compose(self.marker_tilt))
        camera = None
        if frame == self._base_frame:
            pose = odometry.pose.compose(pose)
            camera = odometry.pose.compose(Pose(*lies.translation[:2]))
        detection = MarkerDetection(pose, min(odometry.stamp, received), camera)
        self._markers = [*self._markers, detection][-MOST_MARKERS:]

    def _odometry_at(self, measured_at: float) -> Odometry:
        """Return where the robot was when something was measured.

        Raises:
            ValueError: Odometry does not tell.
        """
        try:
            return self._track.at(measured_at)
        except LookupError as error:
            now, latest = seconds_of(self._node.get_clock().now().to_msg()), self._track.latest_at
            odometry = self._node.resolve_topic_name("odom")
            raise ValueError(
                f"is stamped {error}: do the clocks of their publishers agree? By this machine's clock it is"
                f" {_off(measured_at - now)}, and {odometry} is {_off(latest - now)}"
            ) from None

    def _locate(self, frame: str, measured_at: float) -> tuple[str, Transform]:
        """One of odometry's two frames, and where a frame lies in it at a moment.

        Raises:
            ValueError: It is related to neither.
        """
        if frame in {self.odometry_frame, self._base_frame}:
            return frame, Transform()
        return self._transforms.locate(frame, self.odometry_frame, self._base_frame, measured_at)

    def _take_scan(self, message: LaserScan, received: float) -> None:
        points = points_of(
            message.ranges,
            angle_min=message.angle_min,
            angle_increment=message.angle_increment,
            range_min=message.range_min,
            range_max=message.range_max,
        )
        if self._track.latest is None:
            return  # the robot waits for odometry anyway
        measured_at = seconds_of(message.header.stamp)
        if self.scanner is None:
            frame, lies = self._locate(self._transforms.frame(message.header.frame_id), measured_at)
        else:
            frame, lies = self._base_frame, spatial(self.scanner)
        odometry = self._odometry_at(measured_at)
        points = flatten(points, lies)
        if frame == self._base_frame:
            points = place(points, odometry.pose)
        self._scan = Scan(points, min(odometry.stamp, received))

    def _take_joints(self, message: JointState, received: float) -> None:
        """Of several nodes, each may publish some of the joints."""
        for index, name in enumerate(message.name):
            if name not in self.joint_names:
                continue
            if index >= min(len(message.velocity), len(message.effort)):
                raise ValueError(f"has no velocity or no effort of the joint {name!r}")
            self._joints[name] = Joint(message.velocity[index], message.effort[index], received)

    def _take_range(self, receiver: str, message: Range, received: float) -> None:
        measured = message.range
        if math.isnan(measured):
            raise ValueError("has a range that is not a number")
        if measured > message.max_range:
            measured = math.inf
        arrival = self._track.arrival(seconds_of(message.header.stamp), received)
        self._ranges[receiver] = max(measured, message.min_range, 0.0), arrival

    # Current readings.

    def observe(self, battery: BatteryReading | None) -> Observation:
        """All that is known now.

        Args:
            battery: The battery's latest reading, which comes another way.
        """
        now = control_time(self._node)
        if self._unrelated_since is not None and now - self._unrelated_since >= DISCOVERY:
            topic = self._node.resolve_topic_name(MARKER_TOPIC)
            self._set_fault(topic, f"{topic} {self._doubt}")
        markers, self._markers = self._markers, self._markers[-1:]
        expected_dock = self._expect_dock()
        return Observation(
            now,
            battery,
            self._track.latest,
            markers[-1] if markers else None,
            self._infrared(),
            self._scan,
            other_markers=tuple(markers[:-1]),
            expected_dock=expected_dock,
            localized_at=self._localization.heard_at,
            localization_error=self._localization.error,
            joints=dict(self._joints),
        )

    def _expect_dock(self) -> Pose | None:
        """Return where the database has the dock, in odom; None where tf does not tell."""
        place, odometry = self.place, self._track.latest
        if place is None or odometry is None:
            return None
        try:
            expected = odometry.pose.compose(place.pose.relative_to(self.robot_in(place.frame)))
        except ValueError as error:
            self._node.get_logger().warning(f"The pose of the dock {place.dock!r} is not used: it {error}", once=True)
            return None
        if Sensor.LOCALIZATION in self._subscriptions:
            frame = self._transforms.frame(place.frame)
            stamp = self._transforms.newest(frame, self.odometry_frame, self._base_frame)
            self._localization.note(stamp, control_time(self._node))
        return expected

    def robot_in(self, frame: str) -> Pose:
        """Return where the robot is in a frame, by odometry and tf.

        Args:
            frame: The name of the frame.

        Raises:
            ValueError: It is unknown; the caller adds the subject to the message.
        """
        odometry = self._track.latest
        if odometry is None:
            raise ValueError("cannot be compared with the robot's: no odometry has come yet")
        nearer, lies = self._locate(self._transforms.frame(frame), 0.0)
        robot = Pose() if nearer == self._base_frame else odometry.pose
        return robot.relative_to(pose_of(lies))

    def _infrared(self) -> InfraredReading | None:
        if len(self._ranges) < len(RECEIVERS):
            return None
        (left, center, right) = (self._ranges[name] for name in RECEIVERS)
        return InfraredReading(left[0], center[0], right[0], min(left[1], center[1], right[1]))


def _off(seconds: float) -> str:
    """Return how far a stamp is from now, in words."""
    return f"{abs(seconds):.2f} s {'in the future' if seconds > 0.0 else 'old'}"
