"""Lets simulated robots in one room know where the others are."""

import math
import time

from builtin_interfaces.msg import Time
from geometry_msgs.msg import TransformStamped
from rclpy.node import Node
from rclpy.qos_overriding_options import QoSOverridingOptions

from docking.core.geometry import Pose
from docking.core.transform import spatial
from docking.ros.geometry import transform_message
from docking.ros.simulator_messages import BASE, WORLD
from docking.simulation.obstacle import Obstacle
from docking.simulation.others import Others
from docking.simulation.simulation import Simulation
from robot_io.endpoints import overridable_publisher
from robot_io.qos import LATCHED, latched

PERIOD, REPEAT = 0.1, 2.0
"""Seconds between two messages of a robot that moves, and of one that stands still."""
MOVED = 0.001
"""In m or rad; a robot that has moved by less stands still."""
MOST = 100
"""Robots whose last messages are kept for one that starts."""


class SimulatorOthers:
    """Publishes where this robot is in truth, and reads where the others are."""

    def __init__(self, node: Node, topic: str) -> None:
        """Make the publisher and the subscription.

        Args:
            node: The simulator.
            topic: Of all robots in the room.
        """
        self._name = f"{node.get_namespace().strip('/')}/{BASE}"
        self._others = Others()
        self._bodies: tuple[Obstacle, ...] = ()
        self._told: Pose | None = None
        self._told_at = -math.inf
        self._publisher = overridable_publisher(node, TransformStamped, topic, LATCHED)
        overriding = QoSOverridingOptions.with_default_policies()
        node.create_subscription(TransformStamped, topic, self._hear, latched(MOST), qos_overriding_options=overriding)

    @property
    def bodies(self) -> tuple[Obstacle, ...]:
        """The other robots, as they were known at the last step."""
        return self._bodies

    def step(self, simulation: Simulation, stamp: Time) -> None:
        """Say where the robot is, if it is time, and put the others where they are.

        Args:
            simulation: Of this robot.
            stamp: The moment.
        """
        now, pose = time.monotonic(), simulation.robot.pose
        if now - self._told_at >= (PERIOD if self._has_moved(pose) else REPEAT):
            self._tell(pose, now, stamp)
        self._bodies = self._others.bodies(now)
        simulation.meet(self._bodies)

    def _has_moved(self, pose: Pose) -> bool:
        told = self._told
        return told is None or told.distance_to(pose) > MOVED or abs(told.theta - pose.theta) > MOVED

    def _tell(self, pose: Pose, now: float, stamp: Time) -> None:
        self._told, self._told_at = pose, now
        message = TransformStamped(child_frame_id=self._name, transform=transform_message(spatial(pose)))
        message.header.frame_id = WORLD
        message.header.stamp = stamp
        self._publisher.publish(message)

    def _hear(self, message: TransformStamped) -> None:
        place = message.transform.translation
        if message.child_frame_id != self._name and math.isfinite(place.x) and math.isfinite(place.y):
            self._others.hear(message.child_frame_id, place.x, place.y, time.monotonic())
