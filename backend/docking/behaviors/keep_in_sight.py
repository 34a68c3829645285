"""Handles a dock that goes out of sight on the last metre, or that is seen somewhere else."""

import math

from docking.behaviors.moves import bounded
from docking.core.errors import DockingError
from docking.core.observation import STANDSTILL, Velocity
from docking.goal.plan import DockTarget
from docking.parameters import ApproachSettings, MotionLimits

UNSURE = 0.5
"""How long the dock may be out of sight, in s, before the robot stands still."""
UNSURE_NEARBY = 0.3
"""The same, in s, within blind_distance: there the robot drives on blindly, but has to know first why it is blind."""
WAITING = 1.0
"""How long, in s, it stands still before it backs to see the dock again."""
MISSED = 2.5
"""The first two in usual periods between two detections, if that is longer."""
PEEK = 0.1
"""How far the robot backs to see the dock again, in m."""
PEEK_SPEED = 0.06
"""How fast, in m/s, unless v_linear_min is more."""
SAME_PLACE = 0.02
"""How much farther from the dock, in m, it may go out of sight the next time without being looked for again."""


class KeepInSight:
    """Holds an approach back while the dock is out of sight, or seems to have been moved.

    Within blind_distance a robot may see its dock no longer because it is too near. It may also have been pushed to the
    side. So it backs a little where that happens first, and looks. If the dock is where it was, the robot drives on
    blindly from there.
    """

    def __init__(
        self,
        aim: DockTarget,
        motion: MotionLimits,
        settings: ApproachSettings,
        lost: type[DockingError],
        lost_after: float,
    ) -> None:
        """Start with the dock in sight.

        Args:
            aim: The dock.
            motion: Limits of the robot's motion.
            settings: How it drives. With an infinite blind_distance, it never needs to see the dock.
            lost: The error if the dock is out of sight for too long.
            lost_after: How long that is, in s.
        """
        self._aim = aim
        self._blind_distance = settings.blind_distance
        self._lost = lost
        self._lost_after = lost_after
        self._speed = bounded(max(PEEK_SPEED, motion.v_linear_min), motion.v_linear_back)
        self._unseen = 0.0
        self._seen_at = aim.seen_at
        self._out_of_sight = math.inf if math.isinf(settings.blind_distance) else 0.0
        self._peeks_from: float | None = None

    def look(self, left: float, dt: float) -> DockingError | None:
        """Note whether the dock is in sight.

        Args:
            left: To the docked pose, in m.
            dt: Seconds since the last look.

        Returns:
            The error if the dock is lost, else None.
        """
        self._unseen = self._unseen + dt if self._aim.seen_at == self._seen_at else 0.0
        self._seen_at = self._aim.seen_at
        peeks = self._peeks_from is not None
        if self._unseen <= UNSURE_NEARBY and self._peeks_from is not None:
            self._out_of_sight = max(self._out_of_sight, self._peeks_from + SAME_PLACE)
            self._peeks_from = None
        period = MISSED * self._aim.period
        lost_after = max(UNSURE, period) + max(self._lost_after, period) + (PEEK / self._speed if peeks else 0.0)
        if self._unseen > lost_after and (left > self._blind_distance or peeks or self._aim.disputed):
            return self._lost(f"{self._aim.unseen} for {lost_after:.1f} s (external_detection_timeout)")
        return None

    def hold(self, left: float) -> Velocity | None:
        """Return the velocity while the robot must not drive on; None if it may.

        Args:
            left: To the docked pose, in m.
        """
        if self._aim.disputed:  # in a moment it is known whether the robot was moved
            return STANDSTILL
        nearby = left <= self._blind_distance or self._peeks_from is not None
        if self._unseen <= max(UNSURE_NEARBY if nearby else UNSURE, MISSED * self._aim.period):
            return None
        if not nearby:
            return STANDSTILL
        if left <= self._out_of_sight:
            return None
        if self._unseen <= max(WAITING, 2.0 * MISSED * self._aim.period):
            return STANDSTILL
        if self._peeks_from is None:
            self._peeks_from = left
        return Velocity(-self._speed) if left < self._peeks_from + PEEK else STANDSTILL
