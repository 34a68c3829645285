"""Handles a dock that goes out of sight on the last metre, or that is seen somewhere else."""

import math

from docking.behaviors.moves import bounded
from docking.core.errors import DockingError
from docking.core.observation import STANDSTILL, Velocity
from docking.estimation.dock_estimate import Spread
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
"""How far the robot backs to see the dock again, in m, from where that was seen last."""
PEEK_SPEED = 0.06
"""How fast, in m/s, unless v_linear_min is more."""
FAR = 0.6
"""In m before the docked pose: farther away, a dock is out of sight for another reason than that it is too near."""
BLIND_AT_MOST = 0.35
"""Distance from the docked pose, in m, within which a camera may be too near to its marker, whatever blind_distance.

There the dock must go out of sight twice at the same place, and the docked pose must be known well.
"""
WELL = 0.5
"""Standard deviations with which it is known well, as a part of the tolerances."""
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
        self._well = Spread(WELL * settings.docking_lateral_tolerance, WELL * settings.docking_heading_tolerance)
        self._seen_from = math.inf  # to the docked pose, in m, when the dock was last in sight
        self._gone_at = self._gone_before = math.inf  # the same for the last two times that it was looked for again
        self._lost = lost
        self._lost_after = lost_after
        self._speed = bounded(max(PEEK_SPEED, motion.v_linear_min), motion.v_linear_back)
        self._unseen = 0.0
        self._seen_at = aim.seen_at
        self._out_of_sight = math.inf if math.isinf(settings.blind_distance) else 0.0
        self._peeks_from: float | None = None

    def check(self, left: float, dt: float) -> DockingError | None:
        """Note whether the dock is in sight.

        Args:
            left: To the docked pose, in m.
            dt: Seconds since the last step.

        Returns:
            The error if the dock is lost, else None.
        """
        self._unseen = self._unseen + dt if self._aim.seen_at == self._seen_at else 0.0
        self._seen_at = self._aim.seen_at
        peeks = self._peeks_from is not None
        if self._unseen <= UNSURE_NEARBY and self._peeks_from is not None:
            if self._gone_at <= self._blind_distance or self._is_gone_again:
                self._out_of_sight = max(self._out_of_sight, self._gone_at + SAME_PLACE, self._peeks_from + SAME_PLACE)
            self._gone_before, self._peeks_from = self._gone_at, None
        if self._unseen == 0.0:
            self._seen_from = left
        period = MISSED * self._aim.period
        lost_after = (
            max(UNSURE, period)
            + max(self._lost_after, period)
            + ((self._peek_to - self._peeks_from) / self._speed if self._peeks_from is not None else 0.0)
        )
        blind = left <= max(self._blind_distance, self._out_of_sight)
        if self._unseen > lost_after and (not blind or peeks or self._aim.disputed):
            if self._blind_distance < self._seen_from < FAR:
                self._aim.doubts.count(
                    "blind",
                    f"the dock was seen last {self._seen_from:.2f} m before the docked pose: where the camera sees"
                    f" nothing nearer, blind_distance ({self._blind_distance:g} m) must be larger than that",
                )
            return self._lost(f"{self._aim.unseen} for {lost_after:.1f} s (external_detection_timeout)")
        return None

    @property
    def _is_gone_again(self) -> bool:
        """Whether the dock went out of sight at the same place twice."""
        return abs(self._gone_at - self._gone_before) <= 2.0 * SAME_PLACE

    @property
    def _peek_to(self) -> float:
        """The distance before the docked pose where the dock must be in sight again, in m."""
        if self._peeks_from is None:
            return 0.0
        far = self._gone_at if self._gone_at <= max(self._blind_distance, BLIND_AT_MOST) else 0.0
        return max(self._peeks_from, far) + PEEK

    def hold(self, left: float) -> Velocity | None:
        """Return the velocity while the robot must not drive on; None if it may.

        Args:
            left: To the docked pose, in m.
        """
        if self._aim.disputed:  # in a moment it is known whether the robot was moved
            return STANDSTILL
        too_near = self._seen_from <= BLIND_AT_MOST and self._aim.spread.within(self._well)
        nearby = left <= self._blind_distance or too_near or self._peeks_from is not None
        if self._unseen <= max(UNSURE_NEARBY if nearby else UNSURE, MISSED * self._aim.period):
            return None
        if not nearby:
            return STANDSTILL
        if left <= self._out_of_sight:
            return None
        if self._unseen <= max(WAITING, 2.0 * MISSED * self._aim.period):
            return STANDSTILL
        if self._peeks_from is None:
            self._peeks_from, self._gone_at = left, self._seen_from
        return Velocity(-self._speed) if left < self._peek_to else STANDSTILL
