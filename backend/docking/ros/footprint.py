"""The robot's footprint, for maps: latched, as it changes only with the parameters."""

from geometry_msgs.msg import Point32, PolygonStamped
from rclpy.node import Node
from rclpy.publisher import Publisher

from docking.core.footprint import Footprint
from robot_io.endpoints import overridable_publisher
from robot_io.qos import LATCHED

TOPIC = "footprint"


class FootprintPublisher:
    """The publisher of `footprint`."""

    def __init__(self, node: Node) -> None:
        """Start with nothing published.

        Args:
            node: The node that publishes. All calls must come from the thread that spins it.
        """
        self._node = node
        self._publisher: Publisher | None = None
        self._published: tuple[Footprint, str] | None = None

    def publish(self, footprint: Footprint, frame: str) -> None:
        """Publish a footprint in a frame, unless it is the published one."""
        if (footprint, frame) == self._published:
            return
        if self._publisher is None:
            self._publisher = overridable_publisher(self._node, PolygonStamped, TOPIC, LATCHED)
        message = PolygonStamped()
        message.header.frame_id = frame
        message.header.stamp = self._node.get_clock().now().to_msg()
        message.polygon.points = [Point32(x=x, y=y) for x, y in footprint]
        self._publisher.publish(message)
        self._published = footprint, frame
