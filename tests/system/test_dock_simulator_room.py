"""The room of the dock simulator over DDS: its map, its scan and its frames fit together."""

import math

import pytest
from nav_msgs.msg import OccupancyGrid, Odometry
from sensor_msgs.msg import LaserScan

from docking.core.transform import pose_of as pose_of_transform
from docking.ros.geometry import transform_from
from robot_io.qos import LATCHED
from robot_io.transform_tree import TransformTree
from tests.support.observer import Observer, Recording
from tests.support.simulator import START, SimulatorControls, dock_simulator, moving, pose_of, velocity, wait_for_new
from tests.support.waiting import wait_until
from tf2_msgs.msg import TFMessage

pytestmark = pytest.mark.ros

OFF = "odometry_drift:=0.2", "laser_noise:=0.0", "laser_x:=0.1", "laser_yaw:=0.5", "real_time_factor:=2.0"


def frames_of(*recordings: Recording) -> TransformTree:
    tree = TransformTree()
    for message in [message for recording in recordings for message in recording.messages]:
        for stamped in message.transforms:
            transform = transform_from(stamped.transform.translation, stamped.transform.rotation)
            tree.add(stamped.header.frame_id, stamped.child_frame_id, 0.0, transform, fixed=True)
    return tree


def test_the_map_shows_what_the_scan_sees_where_the_robot_is(domain: int, observer: Observer) -> None:
    with dock_simulator(domain, *OFF):
        truth, scans = observer.record(Odometry, "ground_truth"), observer.record(LaserScan, "scan")
        static, tf = observer.record(TFMessage, "tf_static", LATCHED), observer.record(TFMessage, "tf")
        with observer.publishing(velocity(-0.3, 0.2), "cmd_vel"):
            truth.wait_for(lambda message: pose_of(message).distance_to(START) > 0.8)
        wait_until(lambda: not moving(truth.messages[-1]), "a standstill")
        for later in (scans, tf, tf):
            wait_for_new(later, lambda message: not isinstance(message, TFMessage) or len(message.transforms) == 2)
        grid = observer.record(OccupancyGrid, "map", LATCHED).wait_for(lambda _: True)  # for those who come late, too
        frames, scan = frames_of(static, tf), scans.messages[-1]
        assert scan.header.frame_id == "laser"

        robot, odometry = pose_of(truth.messages[-1]), frames.lookup("odom", "base_link", 0.0)
        believed = pose_of_transform(frames.lookup("map", "base_link", 0.0))
        assert believed.distance_to(robot) < 0.01
        assert math.dist(odometry.translation[:2], (robot.relative_to(START).x, robot.relative_to(START).y)) > 0.03
        laser, info = pose_of_transform(frames.lookup("map", "laser", 0.0)), grid.info
        assert (grid.header.frame_id, info.resolution) == ("map", pytest.approx(0.05))
        for ray, distance in enumerate(scan.ranges):
            if not math.isfinite(distance):
                continue
            angle = laser.theta + scan.angle_min + ray * scan.angle_increment
            x, y = laser.x + distance * math.cos(angle), laser.y + distance * math.sin(angle)
            column, row = int((x - info.origin.position.x) / 0.05), int((y - info.origin.position.y) / 0.05)
            near = [grid.data[info.width * (row + up) + column + side] for up in (-1, 0, 1) for side in (-1, 0, 1)]
            assert max(near) == 100, (x, y)
        assert sum(map(math.isfinite, scan.ranges)) > 300


def test_it_can_do_without(domain: int, observer: Observer) -> None:
    with dock_simulator(domain, "room:=false"):
        scans, tf = observer.record(LaserScan, "scan"), observer.record(TFMessage, "tf")
        scan = scans.wait_for(lambda _: True)
        assert sum(map(math.isfinite, scan.ranges)) < 100
        SimulatorControls(observer).wait_for_status(halted="false")
        wait_until(lambda: len(tf.messages) > 10, "transforms")
        assert all(len(message.transforms) == 1 for message in tf.messages)
        assert observer.node.count_publishers("map") == 0
