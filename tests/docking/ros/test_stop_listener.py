"""Whoever may stop the robot is heard, whatever its quality of service."""

from collections.abc import Iterator

import pytest
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from std_msgs.msg import Bool, String

from docking.ros.process import Spinner
from docking.ros.stop_listener import StopListener
from robot_io.qos import LATCHED
from tests.support.observer import Observer, ros_nodes, ros_observer
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros

BEST_EFFORT = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT, durability=DurabilityPolicy.VOLATILE)
STOP, GO = Bool(data=True), Bool(data=False)


class Robot:
    """A node that obeys stops, and looks ten times a second who is there."""

    def __init__(self, node: Node) -> None:
        self.node = node
        self.changes: list[bool] = []
        self.stops = StopListener(node, lambda: self.changes.append(self.stops.held))
        node.create_timer(0.1, self.stops.scan)

    def wait_for(self, *changes: bool) -> None:
        wait_until(lambda: self.changes == list(changes), f"{changes}, not {self.changes}")


@pytest.fixture
def robot(domain: int) -> Iterator[Robot]:
    with ros_nodes(domain) as context:
        node = Node("robot", context=context)
        robot = Robot(node)
        robot.stops.listen_to(["e_stop"])
        with Spinner(context, [node]) as spinner:
            yield robot
        assert spinner.failure is None


@pytest.mark.parametrize("quality", [10, BEST_EFFORT, LATCHED], ids=["volatile", "best effort", "latched"])
def test_every_publisher_is_heard(robot: Robot, observer: Observer, quality: QoSProfile | int) -> None:
    publisher = observer.call(lambda: observer.node.create_publisher(Bool, "stop_latched", quality))
    # Each side finds the other by itself, and a message that comes in between is lost.
    wait_until(publisher.get_subscription_count, "the publisher has a subscriber")
    wait_until(lambda: robot.node.count_publishers("stop_latched"), "the robot knows the publisher")
    observer.call(lambda: publisher.publish(STOP))
    robot.wait_for(True)
    observer.call(lambda: publisher.publish(GO))
    robot.wait_for(True, False)


@pytest.mark.parametrize("topic", ["text", "e" * 300, "overridden"])
def test_a_topic_that_cannot_be_subscribed_to_counts_as_a_stop(domain: int, topic: str) -> None:
    with ros_nodes(domain, "-p", "qos_overrides./overridden.subscription_volatile.reliability:=none") as context:
        node = Node("robot", context=context)
        node.create_publisher(String, "text", 1)
        robot = Robot(node)
        robot.stops.listen_to([topic])
        robot.stops.scan()
        assert robot.changes == [True]
        robot.stops.listen_to([])
        assert robot.changes == [True, False]
        node.destroy_node()


def test_what_was_said_before_counts(domain: int, observer: Observer) -> None:
    publisher = observer.call(lambda: observer.node.create_publisher(Bool, "stop_latched", LATCHED))
    observer.call(lambda: publisher.publish(STOP))
    with ros_nodes(domain) as context:
        node = Node("late", context=context)
        robot = Robot(node)
        with Spinner(context, [node]):
            robot.wait_for(True)


def test_one_publisher_does_not_release_the_stop_of_another(robot: Robot, domain: int, observer: Observer) -> None:
    with ros_observer(domain, "second") as second:
        with observer.publishing(GO, "stop_latched", 0.02), second.publishing(GO, "e_stop", 0.02):
            second.publish(STOP, "stop_latched")
            robot.wait_for(True)
            said = observer.record(Bool, "e_stop")
            wait_until(lambda: len(said.messages) > 10, "ten messages that release nothing")
            robot.wait_for(True)
            second.publish(GO, "stop_latched")
            robot.wait_for(True, False)
        second.publish(STOP, "e_stop")
        robot.wait_for(True, False, True)
    wait_until(lambda: observer.node.count_publishers("e_stop") == 0, "the end of the publisher")
    robot.wait_for(True, False, True)  # it left, and the robot does not start by itself
