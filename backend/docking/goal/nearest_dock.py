"""Finds the dock that is nearest to the robot, for goals that leave the choice to the server."""

from collections.abc import Callable, Sequence

from docking.core.errors import DockNotInDb
from docking.core.geometry import Pose
from docking.parameters import DockPlace

LONGEST = 2.0
"""Seconds in which odometry and the transforms to the frames of all docks have to come."""


class NearestDock:
    """Compares the docks with the robot, once their frames are known; the robot stands still until then."""

    def __init__(self, places: Sequence[DockPlace], started_at: float) -> None:
        """Begin to look.

        Args:
            places: The docks whose poses are known.
            started_at: Seconds of the control clock.
        """
        self._places = places
        self._until = started_at + LONGEST

    def find(self, now: float, robot_in: Callable[[str], Pose]) -> DockPlace | None:
        """The nearest dock, in a straight line; None while it is not known yet.

        Docks whose frames are still not known after two seconds are left out.

        Args:
            now: Seconds of the control clock.
            robot_in: Where the robot is in a frame; raises ValueError where that is not known.

        Raises:
            DockNotInDb: Nothing tells where the robot is.
        """
        near: list[tuple[float, DockPlace]] = []
        reason = ""
        for place in self._places:
            try:
                near.append((robot_in(place.frame).distance_to(place.pose), place))
            except ValueError as error:
                reason = f"the pose of the dock {place.dock!r} {error}"
        if now < self._until and len(near) < len(self._places):
            return None
        if not near:
            raise DockNotInDb(f"which dock is the nearest is not known: {reason}")
        return min(near, key=lambda one: one[0])[1]
