"""The dock: a solid box with contacts, a marker and an infrared beacon at its front."""

import math
from dataclasses import dataclass

from docking.core.geometry import Pose, normalize_angle
from docking.core.parameter import number, switch
from docking.simulation.obstacle import Obstruction

DOCKED = Pose(-0.2, 0.0, 0.0)
"""base_link of a docked robot, in the marker's frame, which is the world's."""


@dataclass(frozen=True, slots=True)
class DockSettings:
    """Properties of the dock.

    Attributes:
        front: x of the box's front in world, in m. It carries the contacts, whose springs give way by 1 cm beyond
            the docked pose; the marker is set back above it.
        depth: Of the box, in m.
        width: Of the box, in m.
        contact_distance: From the docked pose, within which robot and dock are in contact, in m.
        contact_angle: The same for the angle, in rad.
    """

    front: float = -0.04
    depth: float = 0.2
    width: float = 0.3
    contact_distance: float = 0.02
    contact_angle: float = math.radians(5.0)
    at_back: bool = switch(False, "Whether the robot's contacts are at its back, so that it has to dock backwards.")
    bounce: float = number(
        0.0, 0.0, 60.0, "s", "Time after the first contact for which the charging current is on and off by chance."
    )
    flickers: bool = switch(False, "Whether the charging current never becomes stable: it is 0.4 s on, then 0.3 s off.")


class Dock:
    """Stands at the world's origin, its marker looking along -x."""

    __slots__ = ("_back", "_front", "_side", "settings")

    def __init__(self, settings: DockSettings) -> None:
        self.settings = settings
        self._front = settings.front
        self._back = settings.front + settings.depth
        self._side = 0.5 * settings.width

    @property
    def corners(self) -> tuple[float, float, float, float]:
        """Of the box in world: the least x and y, and the greatest ones, in m."""
        return self._front, -self._side, self._back, self._side

    def in_contact(self, x: float, y: float, theta: float) -> bool:
        """Whether a robot at this pose in world touches the contacts."""
        settings = self.settings
        heading = DOCKED.theta + (math.pi if settings.at_back else 0.0)
        return (
            math.hypot(x - DOCKED.x, y - DOCKED.y) <= settings.contact_distance
            and abs(normalize_angle(theta - heading)) <= settings.contact_angle
        )

    def clearance(self, x: float, y: float) -> float:
        """From a point in world to the box, in m; 0 inside."""
        return math.hypot(max(self._front - x, 0.0, x - self._back), max(abs(y) - self._side, 0.0))

    def obstruct(self, x: float, y: float, radius: float) -> Obstruction | None:
        """Where a round body is kept that wants to be here; None where it is not in the way.

        Args:
            x: Of its centre, in world.
            y: The same.
            radius: In m.
        """
        front, back, side = self._front, self._back, self._side
        if x <= front - radius or x >= back + radius or abs(y) >= side + radius:
            return None
        nearest_x, nearest_y = min(back, max(front, x)), min(side, max(-side, y))
        away_x, away_y = x - nearest_x, y - nearest_y
        distance = math.hypot(away_x, away_y)
        if distance >= radius:
            return None
        if distance > 1e-9:
            away_x, away_y = away_x / distance, away_y / distance
        else:
            away_x, away_y, nearest_x, nearest_y = self._way_out(x, y)
        return Obstruction(nearest_x + away_x * radius, nearest_y + away_y * radius, away_x, away_y)

    def _way_out(self, x: float, y: float) -> tuple[float, float, float, float]:
        """From a point inside the box: the direction of the nearest side, and the point on it."""
        sides = (
            (x - self._front, (-1.0, 0.0, self._front, y)),
            (self._back - x, (1.0, 0.0, self._back, y)),
            (self._side - y, (0.0, 1.0, x, self._side)),
            (self._side + y, (0.0, -1.0, x, -self._side)),
        )
        return min(sides)[1]
