"""The frames of the simulated robot, on `tf` and `tf_static`."""

import math

from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseStamped, TransformStamped
from rclpy.node import Node
from rclpy.publisher import Publisher

from docking.core.geometry import Pose
from docking.core.transform import spatial
from docking.ros.geometry import pose_in_space, stamped_pose, transform_message
from docking.ros.simulator_messages import BASE, LASER, MAP, ODOM, WORLD
from docking.ros.transforms import FIXED, MOVING, TFMessage
from docking.simulation.marker import CAMERA_X
from docking.simulation.parameters import BaseFrame, DetectionFrame
from robot_io.endpoints import overridable_publisher
from robot_io.qos import LATCHED
from robot_io.transform import Transform

HEIGHT = 0.2
"""Of the camera and the marker above base_link, in m."""
CAMERA = Transform((CAMERA_X, 0.0, HEIGHT), (-0.5, 0.5, -0.5, 0.5))
"""The optical frame (REP-103: z ahead, x to the right) of a camera that looks ahead, in base_link."""
FOOTPRINT_HEIGHT = 0.05
"""Of base_link above base_footprint, in m."""
LOCALIZATION_PERIOD = 0.095
"""Between two transforms from the map to odometry, in simulated seconds: with each third message of odometry."""


class SimulatorFrames:
    """Publishes how frames lie in each other, where tf2_msgs is installed, and puts detections into theirs."""

    def __init__(
        self,
        node: Node,
        base: BaseFrame,
        detections: DetectionFrame,
        laser: Pose,
        camera_yaw: float,
        *,
        localizes: bool,
    ) -> None:
        """Make the publishers, and publish what never moves.

        Args:
            node: The node that publishes.
            base: The frame whose pose odometry tells.
            detections: The frame of the marker's detections.
            laser: The laser scanner in base_link.
            camera_yaw: The direction in which the camera looks, in rad.
            localizes: Whether to publish where odometry lies in the map.
        """
        self._base = base.value
        self._detections = detections
        self._localizes = localizes
        self._localized_at = -math.inf
        self._camera = spatial(Pose(theta=camera_yaw)).compose(CAMERA)
        self._moving: Publisher | None = None
        if TFMessage is None:
            return
        self._moving = overridable_publisher(node, TFMessage, MOVING)
        self._fixed = overridable_publisher(node, TFMessage, FIXED, LATCHED)
        now = node.get_clock().now().to_msg()
        transforms = [
            _stamped(BASE, DetectionFrame.CAMERA.value, self._camera, now),
            _stamped(BASE, LASER, spatial(laser, HEIGHT), now),
        ]
        if base is BaseFrame.FOOTPRINT:
            transforms.append(_stamped(base.value, BASE, Transform((0.0, 0.0, FOOTPRINT_HEIGHT)), now))
        if localizes:
            transforms.append(_stamped(MAP, WORLD, Transform(), now))
        self._fixed.publish(TFMessage(transforms=transforms))

    def publish(self, odometry: Pose, origin: Pose, now: float, stamp: Time) -> None:
        """Publish where the robot is by its odometry, and at times where its origin is on the map.

        Args:
            odometry: base_link in odom.
            origin: odom in the map, by the localization.
            now: Simulated seconds.
            stamp: Of the odometry.
        """
        if self._moving is None:
            return
        transforms = [_stamped(ODOM, self._base, spatial(odometry), stamp)]
        if self._localizes and not 0.0 <= now - self._localized_at < LOCALIZATION_PERIOD:
            self._localized_at = now
            transforms.append(_stamped(MAP, ODOM, spatial(origin), stamp))
        self._moving.publish(TFMessage(transforms=transforms))

    def detection(self, marker: Pose, stamp: Time) -> PoseStamped:
        """A detection of the marker.

        Args:
            marker: In base_link.
            stamp: Of the image.
        """
        if self._detections is DetectionFrame.BASE:
            return stamped_pose(marker, BASE, stamp)
        message = PoseStamped(pose=pose_in_space(self._camera.inverse().compose(spatial(marker, HEIGHT))))
        message.header.frame_id = self._detections.value
        message.header.stamp = stamp
        return message


def _stamped(parent: str, child: str, transform: Transform, stamp: Time) -> TransformStamped:
    message = TransformStamped(child_frame_id=child, transform=transform_message(transform))
    message.header.frame_id = parent
    message.header.stamp = stamp
    return message
