"""Solid boxes in the world, their sides along its axes."""

import math
from dataclasses import dataclass

from docking.simulation.obstacle import Obstruction


@dataclass(frozen=True, slots=True)
class Box:
    """A piece of furniture, a wall, or the dock.

    Attributes:
        x_min: Of its sides, in world, in m.
        y_min: The same.
        x_max: The same.
        y_max: The same.
    """

    x_min: float
    y_min: float
    x_max: float
    y_max: float

    def clearance(self, x: float, y: float) -> float:
        """From a point in world to the box, in m; 0 inside."""
        return math.hypot(max(self.x_min - x, 0.0, x - self.x_max), max(self.y_min - y, 0.0, y - self.y_max))

    def obstruct(self, x: float, y: float, radius: float) -> Obstruction | None:
        """Return where a round body is kept that wants to be here; None where the box is not in its way.

        Args:
            x: Of its centre, in world.
            y: The same.
            radius: In m.
        """
        if x <= self.x_min - radius or x >= self.x_max + radius or y <= self.y_min - radius or y >= self.y_max + radius:
            return None
        nearest_x, nearest_y = min(self.x_max, max(self.x_min, x)), min(self.y_max, max(self.y_min, y))
        away_x, away_y = x - nearest_x, y - nearest_y
        distance = math.hypot(away_x, away_y)
        if distance >= radius:
            return None
        if distance > 1e-9:
            away_x, away_y = away_x / distance, away_y / distance
        else:
            away_x, away_y, nearest_x, nearest_y = self._way_out(x, y)
        return Obstruction(nearest_x + away_x * radius, nearest_y + away_y * radius, away_x, away_y)

    def seen_from(self, y: float) -> "Box":
        """Return the box in a world whose origin is `y` metres to the left."""
        return Box(self.x_min, self.y_min - y, self.x_max, self.y_max - y)

    def hides(self, x: float, y: float) -> bool:
        """Whether it stands between a point in world and the origin, where the marker is."""
        enters, leaves = 0.0, 1.0  # on the way from the point to the origin
        for start, least, most in ((x, self.x_min, self.x_max), (y, self.y_min, self.y_max)):
            if start == 0.0:
                if not least < 0.0 < most:
                    return False
                continue
            crossings = sorted(((start - least) / start, (start - most) / start))
            enters, leaves = max(enters, crossings[0]), min(leaves, crossings[1])
        return enters < leaves

    def _way_out(self, x: float, y: float) -> tuple[float, float, float, float]:
        """From a point inside the box: the direction of the nearest side, and the point on it."""
        sides = (
            (x - self.x_min, (-1.0, 0.0, self.x_min, y)),
            (self.x_max - x, (1.0, 0.0, self.x_max, y)),
            (self.y_max - y, (0.0, 1.0, x, self.y_max)),
            (y - self.y_min, (0.0, -1.0, x, self.y_min)),
        )
        return min(sides)[1]
