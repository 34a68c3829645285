"""`cmd_vel`, in the type that its subscribers take: geometry_msgs/Twist, geometry_msgs/TwistStamped, or both."""

from collections.abc import Set as AbstractSet

from geometry_msgs.msg import Twist, Vector3
from rclpy.node import Node
from rclpy.publisher import Publisher

from docking.core.observation import Velocity
from docking.parameters import StampedCmdVel
from robot_io.endpoints import node_name, overridable_publisher
from robot_io.participants import SecondParticipant
from robot_io.rclpy_private import RCLError
from robot_io.velocity import CLASSES, velocity_message
from robot_io.velocity_types import PLAIN, STAMPED, fitting_types

TOPIC = "cmd_vel"


def choose_types(mode: StampedCmdVel, subscribed: AbstractSet[str], published: AbstractSet[str]) -> frozenset[str]:
    """The types to publish.

    Args:
        mode: The configured mode.
        subscribed: The types that others subscribe to.
        published: The types that are published now, which are kept while there is no subscriber.
    """
    if mode is not StampedCmdVel.AUTO:
        return frozenset({STAMPED if mode is StampedCmdVel.TRUE else PLAIN})
    return fitting_types(subscribed, published)


class VelocityPublisher:
    """Publishes velocities on `cmd_vel`.

    Publishers are made and taken back in the thread that spins the node; any thread may publish.

    Attributes:
        mode: Which types to publish.
        frame: The frame of stamped velocities.
    """

    def __init__(self, node: Node, mode: StampedCmdVel = StampedCmdVel.AUTO, frame: str = "base_link") -> None:
        """Make the publishers.

        Args:
            node: The node that publishes.
            mode: Which types to publish.
            frame: The frame of stamped velocities.
        """
        self.mode = mode
        self.frame = frame
        self._node = node
        self._topic = node.resolve_topic_name(TOPIC)
        self._others: dict[str, SecondParticipant] = {}  # by type, as none can have both
        self._unmatched: dict[str, set[str]] = {}  # nodes that subscribe to another type, by type
        # Replaced, never changed: other threads publish.
        self._publishers: dict[str, Publisher] = {}
        self.add_wanted()

    def add_wanted(self) -> None:
        """Publish the types, too, that are wanted and not published yet."""
        for name in sorted(self._wanted() - self._publishers.keys()):
            self._publishers = {**self._publishers, name: self._make(name)}

    def drop_unwanted(self) -> bool:
        """Stop publishing types without subscribers, while the robot stands; return whether there were any.

        Where servers share a DDS participant, all must have dropped a type before one of them can add the other.
        """
        before, wanted = self._publishers, self._wanted()
        self._publishers = {name: publisher for name, publisher in before.items() if name in wanted}
        for name in before.keys() - wanted:
            if not self._node.destroy_publisher(before[name]):
                self._others[name].node.destroy_publisher(before[name])
        return len(self._publishers) < len(before)

    def _wanted(self) -> frozenset[str]:
        # A node that publishes on the topic hears who else drives, as this one does, and is no base. But where there
        # are no others it is one, such as a bridge that passes the topic on in both ways.
        drivers = {node_name(publisher) for publisher in self._node.get_publishers_info_by_topic(TOPIC)} - {""}
        subscribers = self._node.get_subscriptions_info_by_topic(TOPIC)
        bases = [subscriber for subscriber in subscribers if node_name(subscriber) not in drivers]
        types = {subscriber.topic_type for subscriber in bases or subscribers}
        wanted = choose_types(self.mode, types, self._publishers.keys())
        self._unmatched = {}
        for base in bases:
            if base.topic_type not in wanted:
                self._unmatched.setdefault(base.topic_type, set()).add(node_name(base) or "a node")
        return wanted

    @property
    def mismatch(self) -> str | None:
        """A sentence about nodes that subscribe to `cmd_vel` with a type that is not published; None without any."""
        if not self._unmatched:
            return None
        who = " and ".join(
            f"{' and '.join(sorted(nodes))} as {name}" for name, nodes in sorted(self._unmatched.items())
        )
        published = " and ".join(sorted(self._publishers))
        return (
            f"{self._topic} is subscribed to by {who}, but published as {published}, so nothing moves there:"
            f" enable_stamped_cmd_vel is {self.mode}"
        )

    def publish(self, velocity: Velocity) -> None:
        """Publish a velocity in each type.

        Raises:
            Exception: ROS does not take one of the messages; the others are published all the same.
        """
        failure: Exception | None = None
        twist = Twist(linear=Vector3(x=velocity.linear_x, y=velocity.linear_y), angular=Vector3(z=velocity.angular_z))
        for name, publisher in self._publishers.items():
            try:
                publisher.publish(velocity_message(name, twist, self._node, self.frame))
            except Exception as error:  # noqa: BLE001 - raised below
                failure = error
        if failure is not None:
            raise failure

    def _make(self, name: str) -> Publisher:
        """A publisher of a type, on a participant of its own if the node's has the topic with the other type.

        Other nodes of the process decide, too, which type the node's participant has, and may change it.
        """
        try:
            return overridable_publisher(self._node, CLASSES[name], TOPIC)
        except RCLError:
            return self._other_node(name).create_publisher(CLASSES[name], self._topic, 10)

    def _other_node(self, name: str) -> Node:
        if name not in self._others:
            kind = name.rpartition("/")[2].lower()
            self._others[name] = SecondParticipant(self._node, f"{self._node.get_name()}_cmd_vel_{kind}")
        return self._others[name].node

    def close(self) -> None:
        """Leave the other participants, if there are any."""
        for participant in self._others.values():
            participant.close()
        self._others = {}
