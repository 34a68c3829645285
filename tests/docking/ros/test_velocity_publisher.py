"""`cmd_vel` in the type that its subscribers take."""

from collections.abc import Iterator

import pytest
from geometry_msgs.msg import Twist, TwistStamped
from rclpy.node import Node

from docking.core.observation import Velocity
from docking.parameters import StampedCmdVel
from docking.ros.velocity_publisher import PLAIN, STAMPED, VelocityPublisher, choose_types
from tests.support.observer import Observer, ros_nodes, ros_observer
from tests.support.waiting import wait_until

OTHER = "geometry_msgs/msg/Wrench"
AUTO, TRUE, FALSE = StampedCmdVel.AUTO, StampedCmdVel.TRUE, StampedCmdVel.FALSE


@pytest.mark.parametrize(
    ("mode", "subscribed", "published", "wanted"),
    [
        (AUTO, set(), set(), {PLAIN}),
        (AUTO, {PLAIN}, {PLAIN}, {PLAIN}),
        (AUTO, {STAMPED}, {PLAIN}, {STAMPED}),
        (AUTO, {PLAIN, STAMPED}, {PLAIN}, {PLAIN, STAMPED}),
        (AUTO, {OTHER}, set(), {PLAIN}),
        (AUTO, set(), {STAMPED}, {STAMPED}),  # nobody is left: as it was
        (TRUE, {PLAIN}, {PLAIN}, {STAMPED}),
        (FALSE, {STAMPED}, {PLAIN}, {PLAIN}),
    ],
)
def test_the_types_are_those_of_the_subscribers(
    mode: StampedCmdVel, subscribed: set[str], published: set[str], wanted: set[str]
) -> None:
    assert choose_types(mode, subscribed, published) == wanted


@pytest.fixture
def nodes(domain: int) -> Iterator[tuple[Node, Node]]:
    """Two nodes of one process, hence of one DDS participant."""
    with ros_nodes(domain) as context:
        nodes = Node("docks", context=context), Node("undocks", context=context)
        yield nodes
        for node in nodes:
            node.destroy_node()


def look(publisher: VelocityPublisher) -> None:
    """What a standing robot's server does once a second."""
    if not publisher.drop_unwanted():
        publisher.add_wanted()


@pytest.mark.ros
def test_it_follows_its_subscribers(nodes: tuple[Node, Node], domain: int, observer: Observer) -> None:
    both = [VelocityPublisher(node, frame="r1/base_link") for node in nodes]
    wait_until(lambda: [node.count_publishers("cmd_vel") for node in nodes] == [2, 2], "both, and nobody of before")
    stamped = observer.record(TwistStamped, "cmd_vel")

    def published() -> bool:
        for publisher in both:
            look(publisher)
            publisher.publish(Velocity(0.1, 0.2))
        return len(stamped.messages) >= 2

    wait_until(published, "stamped velocities")
    message = stamped.messages[0]
    assert (message.twist.linear.x, message.twist.angular.z) == (0.1, 0.2)
    assert (message.header.frame_id, message.header.stamp.sec > 0) == ("r1/base_link", True)
    assert {info.topic_type for info in observer.node.get_publishers_info_by_topic("/cmd_vel")} == {STAMPED}

    with ros_observer(domain, "second") as second:  # a second participant has the other type, in a moving robot, too
        plain = second.record(Twist, "cmd_vel")

        def heard() -> bool:
            both[0].add_wanted()
            both[0].publish(Velocity(0.3))
            return bool(plain.messages) and stamped.messages[-1].twist.linear.x == 0.3

        wait_until(heard, "velocities of both types")
    for publisher in both:
        publisher.close()


@pytest.mark.ros
def test_a_bridge_that_passes_the_topic_on_in_both_ways_is_a_base(nodes: tuple[Node, Node], observer: Observer) -> None:
    publisher = VelocityPublisher(nodes[0])
    heard = observer.record(TwistStamped, "cmd_vel")
    observer.node.create_publisher(TwistStamped, "cmd_vel", 10)

    def published() -> bool:
        look(publisher)
        publisher.publish(Velocity(0.1))
        return bool(heard.messages)

    wait_until(published, "stamped velocities")
    wait_until(lambda: len(observer.node.get_publishers_info_by_topic("/cmd_vel")) == 2, "one type from the server")
    publisher.close()


@pytest.mark.ros
def test_whoever_hears_nothing_is_named(nodes: tuple[Node, Node], observer: Observer) -> None:
    publisher = VelocityPublisher(nodes[0], FALSE)
    assert publisher.mismatch is None
    observer.record(TwistStamped, "cmd_vel")

    def named() -> bool:
        look(publisher)
        return "/observer" in (publisher.mismatch or "")

    wait_until(named, "the subscriber of the other type")
    assert publisher.mismatch == (
        f"/cmd_vel is subscribed to by /observer as {STAMPED}, but published as {PLAIN}, so nothing moves there:"
        " enable_stamped_cmd_vel is false"
    )
    publisher.mode = TRUE
    look(publisher)
    look(publisher)
    assert publisher.mismatch is None


@pytest.mark.ros
def test_another_node_of_the_process_may_publish_either_type(nodes: tuple[Node, Node]) -> None:
    """Its publisher decides which type is left for others on the participant that they share, whatever came before."""
    one, other = VelocityPublisher(nodes[0], FALSE), VelocityPublisher(nodes[1], TRUE)
    for mode, left in ((TRUE, FALSE), (FALSE, TRUE), (TRUE, FALSE)):
        one.mode = mode
        look(one)
        look(one)
        other.mode = left
        other.add_wanted()  # in a moving robot nothing is dropped
        other.publish(Velocity(0.1))
    for publisher in (one, other):
        publisher.close()
