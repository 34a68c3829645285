"""What the plans that see the dock have in common: their stages, and the way back from the dock."""

import math
from abc import abstractmethod

from docking.behaviors.back_out import BackOut
from docking.behaviors.moves import bounded
from docking.behaviors.reversed import Reversed
from docking.core.errors import Stage
from docking.core.geometry import Pose
from docking.core.observation import Observation
from docking.estimation.dock_estimate import Spread
from docking.goal.behavior import Behavior
from docking.parameters import DockSettings

BLIND_WAY = 0.1
"""How far to back off, in m, where the dock is not known."""


class SightedPlan:
    """Half a plan: the other half knows where the dock is, by one kind of sensor."""

    stages = (Stage.INITIAL_PERCEPTION, Stage.NAV_TO_STAGING_POSE, Stage.CONTROLLING, Stage.WAIT_FOR_CHARGE)

    def __init__(self, settings: DockSettings) -> None:
        """Begin without knowing where the dock is.

        Args:
            settings: What the robot may do, and where it stands when docked, as seen from what is detected.
        """
        self.motion = settings.motion
        self.dock = settings.dock
        self.approach = settings.approach
        self._search_speed = settings.search_speed
        self._detection_timeout = settings.external_detection_timeout
        self._robot: Pose | None = None

    @property
    @abstractmethod
    def docked(self) -> Pose | None:
        """Where base_link is when docked, in odom."""

    @property
    def spread(self) -> Spread:
        """How well the docked pose is known: well enough, unless a plan knows better."""
        return Spread(0.0, 0.0)

    @property
    def period(self) -> float:
        """Seconds between two detections, usually; 0 if that is not known."""
        return 0.0

    @property
    def yaw_bias(self) -> float:
        """The curvature of the way, in rad/m, that odometry does not see."""
        return 0.0

    @property
    def disputed(self) -> bool:
        """Whether the last detections agree on another pose of the dock: not, unless a plan knows better."""
        return False

    @property
    def staging(self) -> Pose | None:
        """Where base_link waits in front of the dock, in odom."""
        docked = self.docked
        return None if docked is None else self.dock.staging(docked)

    def observe(self, observation: Observation) -> None:
        """Keep up with the robot."""
        if observation.odometry is not None:
            self._robot = observation.odometry.pose

    def back_off(self) -> Behavior:
        """Away from the dock to where the staging pose is, or a little where that is not known.

        That is forwards where its back is turned to the dock. If that is not known, the end that sees is.
        """
        staging, distance = -self.dock.staging_x_offset, BLIND_WAY
        turned = self.dock.backward and not self.dock.rotate_to_dock
        if self._robot is not None and self.docked is not None:
            off = self._robot.relative_to(self.docked)
            distance, turned = staging + off.x, abs(off.theta) > 0.5 * math.pi
        back_out = BackOut(bounded(distance, staging), self.motion)
        return Reversed(back_out) if turned else back_out
