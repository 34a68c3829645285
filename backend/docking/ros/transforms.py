"""Listens to `tf` and `tf_static`: how the robot's frames lie in each other."""

from collections.abc import Callable

from geometry_msgs.msg import Transform as TransformMessage
from rclpy.node import Node
from rclpy.qos_overriding_options import QoSOverridingOptions
from rclpy.subscription import Subscription

from docking.ros.geometry import seconds_of, transform_from
from robot_io.qos import latched, volatile
from robot_io.transform import Transform
from robot_io.transform_tree import TransformError, TransformTree, nearer_frame

try:
    from tf2_msgs.msg import TFMessage
except ImportError:  # neither the ROS installation's nor our own
    TFMessage = None

__all__ = ["FIXED", "MOVING", "TFMessage", "Transforms"]

DEPTH = 100
"""Of both topics: each publisher sends its own frames, and no message may push another one out."""
MOVING, FIXED = "tf", "tf_static"
QUALITIES = {MOVING: volatile(DEPTH), FIXED: latched(DEPTH)}


class Transforms:
    """The frames of the robot. All calls must come from the thread that spins the node.

    `tf_static` is subscribed to while it may be needed, `tf`, which comes often, only while someone uses it.

    Attributes:
        prefix: Set before the names of frames that do not begin with it: `robot1/`.
    """

    def __init__(self, node: Node) -> None:
        """Start without subscriptions.

        Args:
            node: The node that subscribes.
        """
        self.prefix = ""
        self._node = node
        self._tree = TransformTree()
        self._users: set[object] = set()
        self._subscriptions: dict[str, Subscription] = {}

    def frame(self, name: str) -> str:
        """The full name of a frame."""
        name = name.removeprefix("/")
        return name if not name or name.startswith(self.prefix) else self.prefix + name

    def switch(self, *, on: bool, prefix: str) -> None:
        """Listen to `tf_static`, or no longer.

        Args:
            on: Whether to listen.
            prefix: The new `prefix`; a change drops all frames and subscribes to `tf_static` again.
        """
        if prefix != self.prefix or not on:
            self.prefix = prefix
            self._tree = TransformTree()
            self._listen(FIXED, on=False)
        self._listen(FIXED, on=on)

    def use(self, user: object, *, on: bool) -> None:
        """Listen to `tf` as long as there is a user."""
        if on:
            self._users.add(user)
        else:
            self._users.discard(user)
        self._listen(MOVING, on=bool(self._users))
        if not self._users:
            self._tree.forget_moving()

    def _listen(self, topic: str, *, on: bool) -> None:
        if on and topic not in self._subscriptions and TFMessage is not None:
            self._subscriptions[topic] = self._node.create_subscription(
                TFMessage,
                topic,
                self._make_callback(fixed=topic == FIXED),
                QUALITIES[topic],
                qos_overriding_options=QoSOverridingOptions.with_default_policies(),
            )
        elif not on and topic in self._subscriptions:
            self._node.destroy_subscription(self._subscriptions.pop(topic))

    def _make_callback(self, *, fixed: bool) -> Callable[[TFMessage], None]:
        topic = self._node.resolve_topic_name(FIXED if fixed else MOVING)

        def take(message: TFMessage) -> None:
            for stamped in message.transforms:
                parent, child = self.frame(stamped.header.frame_id), self.frame(stamped.child_frame_id)
                try:
                    transform = _transform(stamped.transform, child)
                    self._tree.add(parent, child, seconds_of(stamped.header.stamp), transform, fixed=fixed)
                except ValueError as error:
                    self._node.get_logger().error(f"{topic} {error}", throttle_duration_sec=1.0)

        return take

    def newest(self, frame: str, odometry: str, base: str) -> float | None:
        """Return when a frame was last related to odometry, by the publishers' clocks; None where that never changes.

        Args:
            frame: The full name of the frame.
            odometry: The frame that odometry is given in.
            base: The robot's frame.
        """
        try:
            return self._tree.newest(nearer_frame(self._tree, frame, odometry, base), frame)
        except TransformError:
            return None

    def locate(self, frame: str, odometry: str, base: str, measured_at: float) -> tuple[str, Transform]:
        """Relate a frame to odometry's.

        Args:
            frame: The full name of the frame.
            odometry: The frame that odometry is given in.
            base: The robot's frame: odometry's child_frame_id.
            measured_at: The moment; 0 is now.

        Returns:
            `odometry` or `base`, and where the frame lies in it.

        Raises:
            ValueError: There is no way; the caller adds the subject to the message.
        """
        if TFMessage is None:
            raise ValueError(
                f"is given in the frame '{frame}', which cannot be related to '{base}': tf2_msgs is not installed"
            )
        target = base
        try:
            target = nearer_frame(self._tree, frame, odometry, base)
            return target, self._tree.lookup(target, frame, measured_at)
        except TransformError as error:
            topics = " or ".join(self._node.resolve_topic_name(topic) for topic in (MOVING, FIXED))
            raise ValueError(
                f"is given in the frame '{frame}', which cannot be related to '{target}' by {topics}: {error}"
            ) from None


def _transform(message: TransformMessage, child: str) -> Transform:
    try:
        return transform_from(message.translation, message.rotation)
    except ValueError as error:
        raise ValueError(f"{error} (of '{child}')") from None
