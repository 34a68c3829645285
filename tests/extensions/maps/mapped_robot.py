"""A robot in a room, with a map: `python -m tests.extensions.maps.mapped_robot [--namespace /robot1] [--size 200]`.

It stands at (1, 0) in `odom`, which begins at (2, 3) in `map`, turned left by 90°; its laser sees a wall 1 m ahead. For
each SIGUSR1 it publishes the next of the maps `KINDS`.

With `--fixed 120`, its frames are on topics of its own, and each frame that never moves has a publisher of its own: the
first says where `odom` is in `map`, 120 others are parts. A map of its own is advertised, and silent. With `--odd`,
only each second ray of its laser comes back.
"""

import argparse
import contextlib
import itertools
import math
import signal

import numpy as np
import rclpy
from geometry_msgs.msg import PoseStamped, TransformStamped
from nav_msgs.msg import OccupancyGrid, Odometry, Path
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from sensor_msgs.msg import BatteryState, LaserScan

from robot_io.qos import LATCHED
from tf2_msgs.msg import TFMessage

RESOLUTION = 0.05
# Those that come one after another: two maps, and three that cannot be right, the first with too few cells.
KINDS = ("walls", "empty", "short", "nan", "huge")


def grid(kind: str, size: int) -> OccupancyGrid:
    """A room with walls around it, unknown outside; or another map, or one that cannot be right."""
    message = OccupancyGrid()
    message.header.frame_id = "map"
    info = message.info
    info.resolution, info.width, info.height = RESOLUTION, size, size
    info.origin.position.x = info.origin.position.y = -size * RESOLUTION / 4
    info.origin.orientation.w = 1.0
    cells = np.full((size, size), -1, dtype=np.int8)
    edge = size // 10
    if kind != "empty":
        cells[edge:-edge, edge:-edge] = 100
    cells[edge + 2 : -edge - 2, edge + 2 : -edge - 2] = 0
    if kind == "walls":
        cells[size // 2 : size // 2 + 2, edge : size // 2] = 100
    if kind == "nan":
        info.origin.position.x = math.nan
    if kind == "huge":
        info.width = info.height = 200_000
    message.data.frombytes(cells.tobytes() if kind != "short" else b"\0")
    return message


def link(parent: str, child: str, x: float, y: float, theta: float) -> TransformStamped:
    """A frame in another one."""
    message = TransformStamped(child_frame_id=child)
    message.header.frame_id = parent
    message.transform.translation.x, message.transform.translation.y = x, y
    message.transform.rotation.z, message.transform.rotation.w = math.sin(theta / 2), math.cos(theta / 2)
    return message


def publish_fixed(node: Node, parts: list[TransformStamped]) -> None:
    """Publish where `odom` is in `map`, behind a transform that is none, and each part with a publisher of its own."""
    nowhere, place = link("map", "nowhere", math.nan, 0.0, 0.0), link("/map", "/odom", 2.0, 3.0, math.pi / 2)
    for links in ([nowhere, place], *([part] for part in parts)):
        node.create_publisher(TFMessage, "tf_static", LATCHED).publish(TFMessage(transforms=links))
    loose = node.create_publisher(TFMessage, "tf_static", 10)  # keeps nothing for those who come later
    node.create_timer(0.5, lambda: loose.publish(TFMessage(transforms=[link("base_link", "loose", 0.0, 0.0, 0.0)])))


class MappedRobot:
    """The topics of the robot."""

    def __init__(self, node: Node, size: int, *, localized: bool, fixed: int = 0, odd: bool = False) -> None:
        self._node = node
        self._size = size
        self._odd = odd
        self._maps = node.create_publisher(OccupancyGrid, "/map", LATCHED)
        self._battery = node.create_publisher(BatteryState, "battery_status", 10)
        self._odometry = node.create_publisher(Odometry, "odom", 10)
        self._scan = node.create_publisher(LaserScan, "scan", 10)
        self._path = node.create_publisher(Path, "plan", 10)
        self._tf = node.create_publisher(TFMessage, "tf" if fixed else "/tf", 10)
        self._links = [link("odom", "base_link", 1.0, 0.0, 0.0)]
        laser = link("base_link", "laser", 0.1, 0.0, 0.0)
        if fixed:
            node.create_publisher(OccupancyGrid, "map", LATCHED)  # silent, as a map server that is not active
            publish_fixed(node, [laser, *(link("base_link", f"part{index}", 0.0, 0.0, 0.0) for index in range(fixed))])
        else:
            node.create_publisher(TFMessage, "/tf_static", LATCHED).publish(TFMessage(transforms=[laser]))
        if localized and not fixed:
            self._links.append(link("map", "odom", 2.0, 3.0, math.pi / 2))
        self.show("walls")
        node.create_timer(0.1, self.tick)

    def show(self, kind: str) -> None:
        """Publish a map."""
        self._maps.publish(grid(kind, self._size))

    def tick(self) -> None:
        """Publish what comes often."""
        now = self._node.get_clock().now().to_msg()
        self._battery.publish(BatteryState(percentage=0.8, voltage=3.3, power_supply_status=2, present=True))
        odometry = Odometry(child_frame_id="base_link")
        odometry.header.frame_id, odometry.header.stamp = "odom", now
        odometry.pose.pose.position.x, odometry.pose.pose.orientation.w = 1.0, 1.0
        self._odometry.publish(odometry)
        for each in self._links:
            each.header.stamp = now
        self._tf.publish(TFMessage(transforms=self._links))
        scan = LaserScan(angle_min=-0.5, angle_max=0.5, angle_increment=0.001, range_min=0.05, range_max=10.0)
        scan.header.frame_id, scan.header.stamp = "laser", now
        scan.ranges = [1.0 / math.cos(-0.5 + 0.001 * index) for index in range(1001)]
        if self._odd:
            scan.ranges = [0.0 if index % 2 == 0 else each for index, each in enumerate(scan.ranges[:720])]
        self._scan.publish(scan)
        path = Path()
        path.header.frame_id = "map"
        path.poses = [PoseStamped() for _ in range(1000)]
        for index, pose in enumerate(path.poses):
            pose.pose.position.x, pose.pose.position.y = 2.0, 4.0 - 0.003 * index
        self._path.publish(path)


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--namespace", default="/robot1")
    parser.add_argument("--size", type=int, default=200)
    parser.add_argument("--lost", action="store_true", help="without a transform from the map to odometry")
    parser.add_argument("--fixed", type=int, default=0, help="number of publishers of frames that never move")
    parser.add_argument("--odd", action="store_true", help="only each second ray of the laser comes back")
    arguments = parser.parse_args()
    rclpy.init()
    node = rclpy.create_node("mapped_robot", namespace=arguments.namespace)
    robot = MappedRobot(node, arguments.size, localized=not arguments.lost, fixed=arguments.fixed, odd=arguments.odd)
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    kinds = itertools.cycle((*KINDS[1:], KINDS[0]))

    def show_next(*_: object) -> None:
        robot.show(kind := next(kinds))
        print("shows", kind, flush=True)

    signal.signal(signal.SIGUSR1, show_next)
    print("mapped", flush=True)
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        executor.spin()


if __name__ == "__main__":
    main()
