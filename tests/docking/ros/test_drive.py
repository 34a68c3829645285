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
LATE = 0.3
"""Seconds in which the thread that hears messages is busy, and one arrives."""
readings = count()


def moving_on() -> Odometry:
    """Odometry of a robot that never stands."""
    return Odometry(pose=Pose(), velocity=FORWARD, stamp=float(next(readings)))


@pytest.fixture(autouse=True)
def endless(monkeypatch: pytest.MonkeyPatch) -> None:
    """Zero velocity is repeated as long as the robot moves."""
    monkeypatch.setattr(halt, "LONGEST", 1e6)


@pytest.mark.parametrize("other_drives", [True, False])
def test_zero_is_repeated_until_another_node_drives(domain: int, observer: Observer, other_drives: bool) -> None:
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


def test_a_node_that_comes_while_zero_is_repeated_is_heard(domain: int, observer: Observer) -> None:
    with ros_nodes(domain) as context:
        node = Node("docking_server", context=context)
        drive = Drive(node, moving_on)
        wheels = Wheels(observer.record(Twist, "cmd_vel").messages)
        with Spinner(context, [node]) as spinner:
            wait_until(lambda: node.count_subscribers("cmd_vel") >= 1, "the base")
            spinner.call(drive.begin).result(10.0)
            spinner.call(drive.stop).result(10.0)
            wait_until(lambda: wheels.zeros > MANY, "zeros that are repeated while the robot moves")

            def left() -> bool:
                observer.publish(MOTION, "cmd_vel")
                return not drive.halting

            wait_until(left, "the end of the repeats")
            spinner.call(drive.close).result(10.0)
        node.destroy_node()


def test_a_motion_that_came_before_the_stop_and_is_heard_after_it_ends_nothing(domain: int, observer: Observer) -> None:
    with ros_nodes(domain) as context:
        node = Node("docking_server", context=context)
        drive = Drive(node, moving_on)
        wheels = Wheels(observer.record(Twist, "cmd_vel").messages)
        observer.publish(Twist(), "cmd_vel")
        with Spinner(context, [node]) as spinner:
            wait_until(lambda: node.count_publishers("cmd_vel") == 2, "the other driver")
            wait_until(lambda: node.count_subscribers("cmd_vel") >= 1, "the base")
            spinner.call(drive.begin).result(10.0)
            wait_until(lambda: observer.node.count_subscribers("cmd_vel") == 2, "the server that listens")

            def stop_late() -> None:
                observer.publish(MOTION, "cmd_vel")
                time.sleep(LATE)
                drive.stop()

            for _ in range(3):
                spinner.call(stop_late).result(10.0)
                wait_until(lambda: wheels.zeros > MANY, "zeros that are repeated though a motion was heard")
            spinner.call(drive.close).result(10.0)
        node.destroy_node()
