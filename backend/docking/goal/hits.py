"""Remembers where the robot has run into something, so that it comes there slowly the next time."""

import math
from dataclasses import dataclass, field, replace

from docking.core.geometry import Pose

AROUND = 0.35
"""How far around such a place the robot is slow, in m: what it has run into may be some centimetres nearer."""
PASSED = 0.15
"""How far behind the robot such a place is passed, in m: odometry drifts, most of all while the robot pushes."""
KEPT_FOR = 600.0
"""Seconds after which such a place is forgotten: what stood there may be gone."""
MOST = 20
"""Places that are remembered."""


@dataclass
class Hits:
    """The places of a robot that was blocked; kept from goal to goal for a while.

    Attributes:
        places: base_link in odom, with the moment.
    """

    places: list[tuple[Pose, float]] = field(default_factory=list)

    def add(self, robot: Pose, now: float) -> None:
        """Remember a place.

        Args:
            robot: base_link in odom, where the robot was blocked.
            now: The moment.
        """
        self.places = [*self.places[1 - MOST :], (robot, now)]

    def forget(self, now: float) -> None:
        """Forget the places that are old, and those of another clock."""
        self.places = [(place, at) for place, at in self.places if 0.0 <= now - at <= KEPT_FOR]

    def shifted(self, by: float) -> "Hits":
        """Return the places on a clock that is ahead by some seconds."""
        return replace(self, places=[(place, at + by) for place, at in self.places])

    def distance(self, robot: Pose, way: float, linear: float) -> float:
        """Return how far the robot may drive as it likes, in m; infinite where it drives away from all places.

        Args:
            robot: base_link in odom, by the last odometry.
            way: What it has driven since, in m.
            linear: The velocity forward, in m/s.
        """
        nearest = math.inf
        for place, _ in self.places:
            off = place.relative_to(robot)
            if math.copysign(off.x, off.x * linear) > -PASSED:
                nearest = min(nearest, math.hypot(off.x, off.y))
        return max(0.0, nearest - AROUND - max(0.0, math.copysign(way, way * linear)))


def describe(robot: Pose, docked: Pose | None) -> str:
    """Return where the robot was blocked, as a sentence for users.

    Args:
        robot: base_link in odom.
        docked: The same once it is docked; None where that is not known.
    """
    if docked is None:
        return "it was blocked"
    off = robot.relative_to(docked)
    side = "left" if off.y > 0.0 else "right"
    beyond = "before" if off.x <= 0.0 else "beyond"
    return f"it was blocked {abs(off.x):.2f} m {beyond} its docked pose and {abs(off.y):.2f} m to the {side} of it"
