"""The controller `dock_pose`: drives by the pose of a marker on the dock."""

import math

from docking.behaviors.approach import Approach
from docking.behaviors.search import Search
from docking.behaviors.staging import ToStaging
from docking.behaviors.wait_for_charge import WaitForCharge
from docking.core.errors import LostMarker, Stage
from docking.core.geometry import Pose
from docking.core.observation import Observation
from docking.estimation.marker_filter import MarkerFilter
from docking.goal.behavior import Behavior
from docking.goal.plan import KnownPoses
from docking.parameters import Dock, MotionLimits
from docking.plans.sighted import SightedPlan

ENOUGH = 8
"""Detections that must agree before the robot drives."""
IN_VIEW = 0.4
"""How old the last detection may be, in s, for the marker to be in view."""
MEMORY = 1.0
"""How old a detection may be, in s, to be used at all."""


class DockPosePlan(SightedPlan):
    """Finds the marker, drives to the staging pose in front of it, then along a smooth curve onto the dock."""

    lost = LostMarker

    def __init__(self, dock: Dock, motion: MotionLimits, *, search_speed: float, detection_timeout: float) -> None:
        """Begin without knowing where the dock is.

        Args:
            dock: Where the robot stands when docked, and where it waits in front.
            motion: What the robot may do.
            search_speed: How fast to turn while the marker is looked for, in rad/s.
            detection_timeout: For how long the marker may be out of sight on the way to the dock, in s.
        """
        super().__init__(dock, motion, search_speed=search_speed, detection_timeout=detection_timeout)
        self.marker = MarkerFilter(MEMORY)

    @property
    def poses(self) -> KnownPoses:
        """As far as they are known."""
        raw = self.marker.raw
        return KnownPoses(None if raw is None else self.dock.docked(raw), self.docked, self.staging)

    @property
    def docked(self) -> Pose | None:
        """Where base_link is when docked, in odom."""
        marker = self.marker.pose
        return None if marker is None else self.dock.docked(marker)

    def observe(self, observation: Observation) -> None:
        """Keep up with the marker and the robot."""
        self.marker.update(observation)
        super().observe(observation)

    def controller(self, stage: Stage) -> Behavior:
        """A new one for a stage."""
        if stage is Stage.INITIAL_PERCEPTION:
            return self._search()
        if stage is Stage.NAV_TO_STAGING_POSE:
            return ToStaging(self, self.dock, self.motion)
        if stage is Stage.CONTROLLING:
            return Approach(self, self.motion, self.lost, self._detection_timeout)
        if stage is Stage.RETRY:
            return self.back_off()
        return WaitForCharge(self)

    @property
    def seen_at(self) -> float:
        """When the marker was seen last."""
        return self.marker.seen_at

    def _search(self) -> Search:
        marker, robot = self.marker.pose, self._robot
        towards = None if marker is None or robot is None else math.atan2(marker.y - robot.y, marker.x - robot.x)
        self.marker.count = 0
        return Search(
            self.motion,
            self._search_speed,
            sees=lambda now: now - self.marker.seen_at <= IN_VIEW,
            knows=lambda: self.marker.count >= ENOUGH,
            towards=towards,
        )
