"""Chooses the poses of a localization to believe: it drifts a little all the time, and jumps at times."""

import math

from docking.core.geometry import Pose, normalize_angle

JUMP, TURN = 0.04, math.radians(3.0)
"""In m and rad: a pose that is farther from the known one has jumped."""
PERSISTS = 4.0
"""How long a jump must last to be believed, in s: a wrong fix usually ends sooner."""


class SteadyLocalization:
    """Holds a pose that has jumped back, until it has lasted.

    Attributes:
        jumped: Whether the last pose was held back.
        largest: The largest jump, in m.
    """

    def __init__(self) -> None:
        """Start without a pose."""
        self.jumped = False
        self.largest = 0.0
        self._away: Pose | None = None  # where it has jumped to
        self._since = 0.0

    def believes(self, pose: Pose, known: Pose | None, now: float) -> bool:
        """Whether the estimate follows a pose; after a jump has lasted, it begins again with it.

        Args:
            pose: By the localization.
            known: By all poses before, carried on by odometry; None before the first one.
            now: Seconds of the observations' clock.
        """
        if known is None or _near(pose, known):
            self.jumped, self._away = False, None
            return True
        self.jumped = True
        self.largest = max(self.largest, pose.distance_to(known))
        if self._away is None or not _near(pose, self._away):
            self._away, self._since = pose, now
        return now - self._since >= PERSISTS


def _near(one: Pose, other: Pose) -> bool:
    return one.distance_to(other) <= JUMP and abs(normalize_angle(one.theta - other.theta)) <= TURN
