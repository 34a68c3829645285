"""The room in which the dock stands: walls, and furniture inside."""

import math
from dataclasses import dataclass, replace

from docking.core.geometry import Pose
from docking.simulation.box import Box
from docking.simulation.obstacle import Obstruction

STRETCHED_AT = 1.5
"""Where along y a longer room has its additional floor: what stands beyond moves along. In m, in world."""


@dataclass(frozen=True, slots=True)
class Room:
    """A room, whose walls enclose the floor.

    Attributes:
        floor: Between the walls, in world.
        furniture: What stands on it, and walls inside.
        thickness: Of the walls, in m.
        places: Where a robot can be sent, by name: base_link in world.
    """

    floor: Box
    furniture: tuple[Box, ...] = ()
    thickness: float = 0.15
    places: tuple[tuple[str, Pose], ...] = ()

    def extended(self, by: float) -> "Room":
        """Return the room made longer along y.

        Args:
            by: In m.
        """
        places = ((name, replace(pose, y=pose.y + by) if pose.y > STRETCHED_AT else pose) for name, pose in self.places)
        return replace(
            self,
            floor=replace(self.floor, y_max=self.floor.y_max + by),
            furniture=tuple(box.seen_from(-by) if box.y_min > STRETCHED_AT else box for box in self.furniture),
            places=tuple(places),
        )

    def obstruct(self, x: float, y: float, radius: float) -> Obstruction | None:
        """Return where a round body is kept that wants to be here; None where no wall is in its way.

        Args:
            x: Of its centre, in world.
            y: The same.
            radius: In m.
        """
        floor = self.floor
        kept_x = min(floor.x_max - radius, max(floor.x_min + radius, x))
        kept_y = min(floor.y_max - radius, max(floor.y_min + radius, y))
        away_x, away_y = kept_x - x, kept_y - y
        distance = math.hypot(away_x, away_y)
        if distance == 0.0:
            return None
        return Obstruction(kept_x, kept_y, away_x / distance, away_y / distance)


def _table(x_min: float, y_min: float, x_max: float, y_max: float, leg: float = 0.1) -> tuple[Box, ...]:
    """The legs of a table: the scanner sees beneath its top, and so does the robot drive."""
    return tuple(Box(x, y, x + leg, y + leg) for x in (x_min, x_max - leg) for y in (y_min, y_max - leg))


WORKSHOP = Room(
    floor=Box(-9.85, -3.5, 0.15, 4.5),
    furniture=(
        Box(-4.6, 3.8, -2.0, 4.5),  # workbench
        Box(-1.2, 4.0, -0.4, 4.5),  # tool cabinet
        Box(-5.4, -3.5, -2.6, -3.05),  # shelves
        Box(-1.2, -3.5, -0.5, -2.8),  # drill press
        Box(-3.35, -2.2, -3.05, -1.9),  # column
        Box(-6.1, 1.7, -6.0, 4.5),  # wall of the store
        Box(-9.85, 1.7, -7.1, 1.8),  # the same, beside its doorway
        Box(-9.85, 2.2, -9.4, 4.1),  # shelves in the store
        Box(-8.4, 3.9, -7.0, 4.5),  # desk in the store
        Box(-9.85, -1.4, -9.0, 0.4),  # lathe
        Box(-9.3, -3.1, -8.1, -2.3),  # pallet
        *_table(-7.6, -1.7, -6.1, -0.8),
    ),
    places=(
        ("workbench", Pose(-3.3, 3.4, math.pi / 2)),
        ("shelf", Pose(-4.0, -2.6, -math.pi / 2)),
        ("store", Pose(-7.6, 3.0, math.pi / 2)),
        ("lathe", Pose(-8.5, -0.5, math.pi)),
        ("waiting", Pose(-5.4, 0.6, 0.0)),
    ),
)
"""A small workshop of 10 m x 8 m with the dock at its right wall; everything fits a grid of 5 cm."""
