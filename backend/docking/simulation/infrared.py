"""The three infrared receivers at the robot's front, and the beacon at the dock's."""

import math
from dataclasses import dataclass
from random import Random

from docking.core.geometry import Pose, normalize_angle
from docking.core.parameter import number

UNSEEN = (math.inf, math.inf, math.inf)


@dataclass(frozen=True, slots=True)
class InfraredSettings:
    """Settings of how well the beacon is seen.

    Attributes:
        rate: Readings a second.
        minimum: The shortest distance that is reported, in m.
        field_of_view: Of each receiver, from edge to edge, in rad.
        beacon_angle: How far to each side the beacon shines, in rad.
        receiver_x: Where the receivers are, x in base_link, in m.
        receiver_angle: How far the left and the right one are turned away from straight ahead, in rad.
    """

    rate: float = 15.0
    minimum: float = 0.02
    range: float = number(2.0, 0.0, 50.0, "m", "Maximum range of the infrared receivers.")
    field_of_view: float = 0.5
    beacon_angle: float = math.radians(60.0)
    noise: float = number(0.01, 0.0, 1.0, "m", "Standard deviation of the measured distance to the beacon.")
    ghosts: float = number(0.0, 0.0, 1.0, "", "Fraction of the infrared distances that are random.")
    hidden_every: float = number(0.0, 0.0, 3600.0, "s", "Period at which something hides the beacon; 0: never.")
    hidden_for: float = number(0.5, 0.0, 3600.0, "s", "Time for which it hides the beacon.")
    receiver_x: float = 0.15
    receiver_angle: float = math.radians(20.0)


class InfraredReceivers:
    """Measure the distance to the beacon, which is where the marker is."""

    __slots__ = ("_hidden_from", "_random", "_wrong", "settings")

    def __init__(self, settings: InfraredSettings, random: Random, wrong: Random) -> None:
        """Mount the receivers.

        Args:
            settings: How well they see.
            random: Where noise comes from.
            wrong: Where ghosts come from, and when the beacon is first hidden.
        """
        self.settings = settings
        self._random = random
        self._wrong = wrong
        self._hidden_from = wrong.uniform(0.0, settings.hidden_every)

    def measure(
        self, robot: Pose, now: float = 0.0, *, hidden: bool = False, ghosts: float = 0.0
    ) -> tuple[float, float, float]:
        """The distances of the left, the center and the right one, in m; infinite where the beacon is not seen.

        Args:
            robot: base_link in world.
            now: Seconds since the start.
            hidden: Whether something hides the beacon.
            ghosts: The part of the distances that are anything, beyond that of the settings.
        """
        settings = self.settings
        ranges = UNSEEN if hidden or self._is_hidden(now) else self._measure(robot)
        ghosts = max(ghosts, settings.ghosts)
        if ghosts == 0.0:
            return ranges
        left, center, right = (
            self._wrong.uniform(settings.minimum, settings.range) if self._wrong.random() < ghosts else distance
            for distance in ranges
        )
        return left, center, right

    def _is_hidden(self, now: float) -> bool:
        every = self.settings.hidden_every
        return every > 0.0 and (now - self._hidden_from) % every < self.settings.hidden_for

    def _measure(self, robot: Pose) -> tuple[float, float, float]:
        settings = self.settings
        receivers = robot.compose(Pose(settings.receiver_x))
        distance = math.hypot(receivers.x, receivers.y)
        if distance > settings.range or abs(math.atan2(receivers.y, -receivers.x)) > settings.beacon_angle:
            return UNSEEN
        bearing = math.atan2(-receivers.y, -receivers.x) - robot.theta
        angle = settings.receiver_angle
        left, center, right = (self._one(distance, bearing - direction) for direction in (angle, 0.0, -angle))
        return left, center, right

    def _one(self, distance: float, angle: float) -> float:
        settings = self.settings
        if abs(normalize_angle(angle)) > 0.5 * settings.field_of_view:
            return math.inf
        measured = distance + self._random.gauss(0.0, settings.noise)
        return min(settings.range, max(settings.minimum, measured))
