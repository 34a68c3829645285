"""Presses beside each other that feel for the contacts, where the dock's pose is known only roughly."""

import math
from collections.abc import Callable
from dataclasses import replace
from itertools import product

from docking.behaviors.approach import Approach
from docking.behaviors.combined import Sequence
from docking.behaviors.straight import BackOut
from docking.core.errors import FailedToControl
from docking.core.geometry import Pose
from docking.estimation.dock_estimate import Spread
from docking.goal.behavior import Behavior
from docking.goal.doubts import Doubts
from docking.goal.plan import DockTarget
from docking.parameters import ApproachSettings, MotionLimits

BACK = 0.6
"""How far before the docked pose each press begins, in m: the robot has to get to the side."""
SIDES = (0.0, 0.025, -0.025, 0.05, -0.05, 0.075, -0.075)
"""How far to the left of the docked pose it presses, in m."""
TURNS = (0.0, math.radians(3.5), math.radians(-3.5))
"""How far it is turned to the left there, in rad."""
LIKELY = Spread(0.05, math.radians(2.0))
"""How far off the pose of the dock usually is: the likelier places come first. Most contacts forgive a turn."""
TOLERANT = 2.0
"""How many times the usual tolerances a press may be off: the next one is elsewhere anyway."""


def _likelihood(offset: Pose) -> float:
    return math.hypot(offset.y / LIKELY.lateral, offset.theta / LIKELY.heading)


OFFSETS = tuple(sorted((Pose(0.0, y, turn) for turn, y in product(TURNS, SIDES)), key=_likelihood))[1:]
"""From the docked pose, one after another; at that itself the robot has pressed before."""


class BesideDock(DockTarget):
    """The dock as a target that is a little beside it."""

    def __init__(self, aim: DockTarget, offset: Pose) -> None:
        """Follow another target.

        Args:
            aim: The dock.
            offset: Where to press, from the docked pose.
        """
        self._aim = aim
        self._offset = offset

    @property
    def docked(self) -> Pose | None:
        """The pose of base_link while it presses, in odom."""
        docked = self._aim.docked
        return None if docked is None else docked.compose(self._offset)

    @property
    def seen_at(self) -> float:
        """The time when the dock was seen last."""
        return self._aim.seen_at

    @property
    def doubts(self) -> Doubts:
        """The doubts of the way so far."""
        return self._aim.doubts

    @property
    def stalled(self) -> bool:
        """Whether the joints of the wheels tell that these stall."""
        return self._aim.stalled

    @property
    def yaw_bias(self) -> float:
        """The curvature of the way, in rad/m, that odometry does not see."""
        return self._aim.yaw_bias


def press_beside(
    aim: DockTarget,
    offset: Pose,
    motion: MotionLimits,
    settings: ApproachSettings,
    push_on: Callable[[Callable[[], Behavior]], Behavior],
    *,
    staging: float,
) -> Behavior:
    """Back, and on again a little beside; slowly near the dock, as every approach.

    Args:
        aim: The dock.
        offset: Where to press, from the docked pose.
        motion: Limits of the robot's motion.
        settings: How it drives.
        push_on: Adds the push at the end.
        staging: How far before the docked pose the staging pose is, in m: the robot does not back beyond it.
    """
    blind = replace(
        settings,
        blind_distance=math.inf,
        look_timeout=0.0,
        docking_lateral_tolerance=TOLERANT * settings.docking_lateral_tolerance,
        docking_heading_tolerance=TOLERANT * settings.docking_heading_tolerance,
    )
    target = BesideDock(aim, offset)
    return Sequence(
        lambda: BackOut(min(BACK, staging), motion, target.docked),
        lambda: push_on(lambda: Approach(target, motion, blind, FailedToControl, math.inf)),
    )
