"""The camera of the simulated robot: draws what it sees while something subscribes to it."""

import importlib.util
import math
import time

from builtin_interfaces.msg import Time
from rclpy.node import Node
from rclpy.qos import QoSProfile
from sensor_msgs.msg import CameraInfo, CompressedImage

from docking.simulation.drawing import HEIGHT, WIDTH, Scene, draw, focal_length
from docking.simulation.faults import Fault
from docking.simulation.marker import MarkerSettings
from docking.simulation.parameters import DetectionFrame
from docking.simulation.simulation import Simulation
from robot_io.endpoints import overridable_publisher

PERIOD = 0.2
"""Between two pictures, in s."""
QUALITY = 80
NEWEST = QoSProfile(depth=1)


class SimulatorCamera:
    """Publishes pictures where simplejpeg is installed, which encodes them."""

    def __init__(self, node: Node) -> None:
        """Make the publishers.

        Args:
            node: The node that publishes.
        """
        self._due = -math.inf
        self._encodes = importlib.util.find_spec("simplejpeg") is not None
        if self._encodes:
            self._pictures = overridable_publisher(node, CompressedImage, "camera/image_raw/compressed", NEWEST)
            self._info = overridable_publisher(node, CameraInfo, "camera/camera_info", NEWEST)

    def publish(self, simulation: Simulation, stamp: Time) -> None:
        """Publish a picture if one is due and something subscribes to it.

        Args:
            simulation: What there is to see, and where from.
            stamp: Of the picture.
        """
        now = time.monotonic()
        if not self._encodes or now < self._due or not self._pictures.get_subscription_count():
            return
        self._due = now + PERIOD
        import simplejpeg  # noqa: PLC0415 - only if something looks

        marker = simulation.settings.marker
        covered = Fault.OCCLUDED_MARKER in simulation.faults
        scene = Scene(simulation.dock, simulation.settings.room, simulation.obstacles, covered)
        pixels = draw(scene, simulation.robot.pose, marker.camera_yaw, marker.field_of_view, marker.second_y)
        picture = CompressedImage(format="rgb8; jpeg compressed bgr8", data=simplejpeg.encode_jpeg(pixels, QUALITY))
        info = _camera_info(marker)
        info.header.stamp = picture.header.stamp = stamp
        info.header.frame_id = picture.header.frame_id = DetectionFrame.CAMERA.value
        self._info.publish(info)
        self._pictures.publish(picture)


def _camera_info(settings: MarkerSettings) -> CameraInfo:
    focal, x, y = focal_length(settings.field_of_view), 0.5 * WIDTH, 0.5 * HEIGHT
    return CameraInfo(
        width=WIDTH,
        height=HEIGHT,
        distortion_model="plumb_bob",
        d=[0.0] * 5,
        k=[focal, 0.0, x, 0.0, focal, y, 0.0, 0.0, 1.0],
        r=[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        p=[focal, 0.0, x, 0.0, 0.0, focal, y, 0.0, 0.0, 0.0, 1.0, 0.0],
    )
