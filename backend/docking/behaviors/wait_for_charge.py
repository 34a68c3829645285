"""Stands on the dock until the battery charges."""

import math

from docking.core.errors import PushedOff
from docking.core.geometry import Pose
from docking.core.observation import STANDSTILL, Observation, Velocity
from docking.goal.behavior import Failed
from docking.goal.plan import DockTarget

MOVED = 0.03
"""How far the wheels may turn, in m, without a command."""
PUSHED = 0.06
"""Distance from the docked pose, in m, beyond which a robot is no longer docked."""
TURNED = math.radians(12.0)
"""The same for both, in rad."""


class WaitForCharge:
    """Stands still, and sees whether someone moves the robot away from the dock."""

    def __init__(self, aim: DockTarget) -> None:
        """Start on the dock.

        Args:
            aim: The dock.
        """
        self._aim = aim
        self._start: Pose | None = None

    def step(self, observation: Observation, dt: float) -> Velocity | Failed:
        """Stand still."""
        docked, odometry = self._aim.docked, observation.odometry
        if docked is None or odometry is None:
            return STANDSTILL
        self._start = self._start or odometry.pose
        for origin, way in ((self._start, MOVED), (docked, PUSHED)):
            off = odometry.pose.relative_to(origin)
            if math.hypot(off.x, off.y) > way or abs(off.theta) > TURNED:
                return Failed(
                    PushedOff(
                        f"the robot was moved {math.hypot(off.x, off.y):.2f} m and"
                        f" {math.degrees(off.theta):.0f} degrees off the dock"
                    )
                )
        return STANDSTILL
