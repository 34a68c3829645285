"""The three infrared receivers at the robot's front, and the beacon at the dock's."""

import math
from dataclasses import dataclass
from random import Random

from docking.core.geometry import Pose
from docking.core.parameter import number

RECEIVER_X = 0.15
"""The receivers are at the robot's front: x in base_link, in m."""
DIRECTIONS = (math.radians(20.0), 0.0, math.radians(-20.0))
"""Where the left, the centre and the right one look, in rad from straight ahead."""
UNSEEN = (math.inf, math.inf, math.inf)


@dataclass(frozen=True, slots=True)
class InfraredSettings:
    """How well the beacon is seen.

    Attributes:
        rate: Readings a second.
        minimum: The shortest distance that is told, in m.
        field_of_view: Of each receiver, from edge to edge, in rad.
        beacon_angle: How far to each side the beacon shines, in rad.
    """

    rate: float = 15.0
    minimum: float = 0.02
    range: float = number(2.0, 0.0, 50.0, "m", "Maximum range of the infrared receivers.")
    field_of_view: float = 0.5
    beacon_angle: float = math.radians(60.0)
    noise: float = number(0.01, 0.0, 1.0, "m", "Standard deviation of the measured distance to the beacon.")


class InfraredReceivers:
    """Measure the distance to the beacon, which is where the marker is."""

    __slots__ = ("_random", "settings")

    def __init__(self, settings: InfraredSettings, random: Random) -> None:
        """Mount the receivers.

        Args:
            settings: How well they see.
            random: Where noise comes from.
        """
        self.settings = settings
        self._random = random

    def measure(self, robot: Pose) -> tuple[float, float, float]:
        """The distances of the left, the centre and the right one, in m; infinite where the beacon is not seen.

        Args:
            robot: base_link in world.
        """
        settings = self.settings
        beacon = robot.inverse()
        x, y = beacon.x - RECEIVER_X, beacon.y
        distance = math.hypot(x, y)
        receiver_x = robot.x + RECEIVER_X * math.cos(robot.theta)
        receiver_y = robot.y + RECEIVER_X * math.sin(robot.theta)
        if distance > settings.range or abs(math.atan2(receiver_y, -receiver_x)) > settings.beacon_angle:
            return UNSEEN
        bearing = math.atan2(y, x)
        left, center, right = (self._one(distance, bearing - direction) for direction in DIRECTIONS)
        return left, center, right

    def _one(self, distance: float, angle: float) -> float:
        settings = self.settings
        if abs(angle) > 0.5 * settings.field_of_view:
            return math.inf
        measured = distance + self._random.gauss(0.0, settings.noise)
        return min(settings.range, max(settings.minimum, measured))
