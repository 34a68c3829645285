"""Zero velocity is repeated while the robot moves, until another node drives it."""

import time
from itertools import count

import pytest
from geometry_msgs.msg import Twist, Vector3
from rclpy.node import Node

from docking.core.geometry import Pose
from docking.core.observation import STANDSTILL, Odometry, Velocity
from docking.ros.process import Spinner
from docking.ros.velocity import Drive
from robot_io import halt
from tests.support.docking import Wheels
from tests.support.observer import Observer, ros_nodes
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros

FORWARD = Velocity(0.1, 0.0)
MOTION = Twist(linear=Vector3(x=0.2))
MANY = 3 * halt.REPEATS
readings = count()


def moving_on() -> Odometry:
    """Odometry of a robot that never stands."""
    return Odometry(pose=Pose(), velocity=FORWARD, stamp=float(next(readings)))


@pytest.mark.parametrize("other_drives", [True, False])
def test_zero_is_repeated_until_another_node_drives(
    domain: int, observer: Observer, monkeypatch: pytest.MonkeyPatch, other_drives: bool
) -> None:
    monkeypatch.setattr(halt, "LONGEST", 1e6)
    with ros_nodes(domain) as context:
        node = Node("docking_server", context=context)
        drive = Drive(node, moving_on)
        wheels = Wheels(observer.record(Twist, "cmd_vel").messages)
        # It is a publisher before the goal begins, so that it is heard, and its zero is no motion.
        observer.publish(Twist(), "cmd_vel")
        with Spinner(context, [node]) as spinner:
            wait_until(lambda: node.count_publishers("cmd_vel") == 2, "the other driver")
            wait_until(lambda: node.count_subscribers("cmd_vel") >= 1, "the base")
            spinner.call(drive.begin).result(10.0)

            def stop() -> None:
                drive.go(FORWARD, time.monotonic())
                drive.go(STANDSTILL, time.monotonic())

            spinner.call(stop).result(10.0)
            observer.publish(Twist(), "cmd_vel")
            wait_until(lambda: wheels.zeros > MANY, "zeros that are repeated while the robot moves")
            assert drive.halting
            if other_drives:

                def left() -> bool:
                    observer.publish(MOTION, "cmd_vel")
                    return not drive.halting

                wait_until(left, "the end of the repeats")
                observer.publish(MOTION, "cmd_vel")
                wait_until(lambda: wheels.messages[-1] == MOTION, "the motion as the last command")
            else:
                zeros = wheels.zeros
                wait_until(lambda: wheels.zeros > zeros + MANY, "more zeros")
            spinner.call(drive.leave).result(10.0)
            spinner.call(drive.close).result(10.0)
        node.destroy_node()
