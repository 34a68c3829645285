"""The dock: a solid box with contacts, a marker and an infrared beacon at its front."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from docking.core.geometry import Pose, normalize_angle
from docking.core.parameter import number, switch
from docking.simulation.box import Box

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
    travel: float = number(
        0.0,
        0.0,
        0.1,
        "m",
        "How much farther than the docked pose the robot must push the contacts, which are on springs, until a current "
        "flows.",
    )
    lip: float = number(
        0.0,
        0.0,
        60.0,
        "s",
        "Time for which the robot must push against a lip on the floor, 4 cm before its docked pose, until it gets "
        "over it; 0: there is no lip.",
    )


class Dock:
    """Stands at the world's origin, its marker looking along -x; others of its kind may stand along the same wall.

    Attributes:
        boxes: What of each is solid.
        docked: base_link of a robot from which a current flows, in world, at the first one.
        places: y of each, in world; 0 is the first one.
    """

    __slots__ = ("boxes", "docked", "places", "settings")

    def __init__(self, settings: DockSettings, others: Sequence[float] = ()) -> None:
        """Put it up.

        Args:
            settings: Properties of each.
            others: How far to the left of the first one others stand, in m.
        """
        self.settings = settings
        self.places = (0.0, *others)
        give = settings.travel + settings.contact_distance if settings.travel else 0.0
        side, front = 0.5 * settings.width, settings.front + give
        self.boxes = tuple(Box(front, y - side, front + settings.depth, y + side) for y in self.places)
        self.docked = Pose(DOCKED.x + give, DOCKED.y, math.pi if settings.at_back else 0.0)

    def in_contact(self, x: float, y: float, theta: float) -> bool:
        """Whether a robot at this pose in world touches the contacts."""
        settings, docked = self.settings, self.docked
        return (
            math.hypot(x - docked.x, y - self.nearest(y) - docked.y) <= settings.contact_distance
            and abs(normalize_angle(theta - docked.theta)) <= settings.contact_angle
        )

    def clearance(self, x: float, y: float) -> float:
        """From a point in world to the nearest box, in m; 0 inside."""
        return min(box.clearance(x, y) for box in self.boxes)

    def nearest(self, y: float) -> float:
        """Return where, along y, the dock is that is the nearest to a point in world."""
        return min(self.places, key=lambda place: abs(place - y))
