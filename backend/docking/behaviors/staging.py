"""Drives to the staging pose in front of the dock."""

import math

from docking.behaviors.moves import drive_to, turn
from docking.core.geometry import normalize_angle
from docking.core.observation import STANDSTILL, Observation, Velocity
from docking.estimation.dock_estimate import Spread
from docking.goal.behavior import Done
from docking.goal.plan import DockTarget
from docking.parameters import Dock, MotionLimits

REACHED = 0.03
"""How near the robot must get to its staging pose, in m, before it turns to the dock."""
LATERAL = 0.05
"""Largest lateral error of the robot at the staging pose once it has turned and seen the dock from near, in m."""
AHEAD = 0.12
"""Largest error to the front and to the back, in m."""
STRAIGHT = math.radians(3.0)
"""How straight it must look at the dock, in rad."""
SURE = Spread(0.01, math.radians(2.0))
"""How well the docked pose must be known before the approach."""
LONGEST_LOOK = 10.0
"""For how long the robot stands still and looks until it is known so well, in s."""


class ToStaging:
    """Straight to the staging pose, then round to the dock; once more where that was not good enough.

    On the way the dock may be out of sight: odometry will do.
    """

    def __init__(self, aim: DockTarget, dock: Dock, motion: MotionLimits, sure: Spread = SURE) -> None:
        """Plan nothing yet: each step uses the latest estimate of the dock.

        Args:
            aim: The dock.
            dock: Where the staging pose lies from there.
            motion: Limits of the robot's motion.
            sure: How well the docked pose must be known before it is done.
        """
        self._aim = aim
        self._dock = dock
        self._motion = motion
        self._sure = sure
        self._driving = True
        self._looked = 0.0

    def step(self, observation: Observation, dt: float) -> Velocity | Done:
        """Drive, then turn."""
        docked, odometry = self._aim.docked, observation.odometry
        if docked is None or odometry is None:
            return STANDSTILL
        robot, staging = odometry.pose, self._dock.staging(docked)
        motion = self._motion.with_braking(observation.braking)
        if self._driving:
            if robot.distance_to(staging) > REACHED:
                return drive_to(robot, staging, motion)
            self._driving = False
        off = robot.relative_to(staging)
        if abs(off.theta) > STRAIGHT:
            return turn(normalize_angle(-off.theta), motion)
        if abs(off.y) > LATERAL or abs(off.x) > AHEAD:
            self._driving = True
            return STANDSTILL
        if not self._aim.spread.within(self._sure) and self._looked < LONGEST_LOOK:
            self._looked += dt
            return STANDSTILL
        return Done()
