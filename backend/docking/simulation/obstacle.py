"""Solid round things in the world: the robot runs into them, and they hide the marker."""

import math
from dataclasses import dataclass, replace


@dataclass(frozen=True, slots=True)
class Obstruction:
    """The place where a round body is kept that would be inside something solid.

    Attributes:
        x: Of its centre, in world.
        y: The same.
        normal_x: The direction away from the surface, of length 1.
        normal_y: The same.
    """

    x: float
    y: float
    normal_x: float
    normal_y: float


@dataclass(frozen=True, slots=True)
class Obstacle:
    """A pillar, a leg of a person, or another robot.

    Attributes:
        x: Of its centre, in world, in m.
        y: The same.
        radius: In m.
        low: Whether the camera sees over it.
    """

    x: float
    y: float
    radius: float
    low: bool = False

    def obstruct(self, x: float, y: float, radius: float) -> Obstruction | None:
        """Return where a round body is kept that wants to be here; None if the obstacle is not in its way.

        Args:
            x: Of its centre, in world.
            y: The same.
            radius: In m.
        """
        away_x, away_y, reach = x - self.x, y - self.y, self.radius + radius
        distance = math.hypot(away_x, away_y)
        if distance >= reach:
            return None
        away_x, away_y = (away_x / distance, away_y / distance) if distance > 1e-9 else (-1.0, 0.0)
        return Obstruction(self.x + reach * away_x, self.y + reach * away_y, away_x, away_y)

    def seen_from(self, y: float) -> "Obstacle":
        """Return the obstacle in a world whose origin is `y` metres to the left."""
        return replace(self, y=self.y - y)

    def hides(self, x: float, y: float) -> bool:
        """Whether it stands between a point in world and the origin, where the marker is."""
        length = math.hypot(x, y)
        if self.low or length < 1e-9:
            return False
        along = (self.x * x + self.y * y) / length
        across = abs(self.x * y - self.y * x) / length
        return 0.0 < along < length and across < self.radius
