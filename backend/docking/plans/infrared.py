"""The controller `infrared`: drives by three receivers and a beacon on the dock."""

import math

from docking.behaviors.approach import Approach
from docking.behaviors.scan import Scan
from docking.behaviors.search import Search
from docking.behaviors.sequence import Sequence
from docking.behaviors.sidestep import Sidestep
from docking.behaviors.staging import ToStaging
from docking.behaviors.wait_for_charge import WaitForCharge
from docking.core.errors import InfraredLost, Stage
from docking.core.geometry import Pose
from docking.core.observation import Observation
from docking.estimation.beacon_filter import FRESH, BeaconFilter
from docking.goal.behavior import Behavior
from docking.goal.plan import Poses
from docking.parameters import Dock, MotionLimits, Receivers
from docking.plans.sighted import SightedPlan

ENOUGH = 3
"""Readings that must see the beacon before the robot moves on."""
LAST_LOOK = 0.25
"""Where the direction is learned once more, in m before the docked pose."""


class InfraredPlan(SightedPlan):
    """Finds the beacon, then the edge of its light, and so the dock's axis; along that it drives onto the dock.

    Each retry looks for the other edge: with both, the axis is the better known.
    """

    lost = InfraredLost

    def __init__(
        self, dock: Dock, motion: MotionLimits, receivers: Receivers, *, search_speed: float, detection_timeout: float
    ) -> None:
        """Begin without knowing where the dock is.

        Args:
            dock: Where the robot stands when docked, as seen from the beacon, and where it waits in front.
            motion: What the robot may do.
            receivers: How they are mounted.
            search_speed: How fast to turn while the beacon is looked for, in rad/s.
            detection_timeout: For how long the beacon may be out of sight on the way to the dock, in s.
        """
        super().__init__(dock, motion, search_speed=search_speed, detection_timeout=detection_timeout)
        self.beacon = BeaconFilter(receivers)
        self._side = 1
        self._needed = False  # whether the stage needs the receivers

    @property
    def poses(self) -> Poses:
        """As far as they are known; there is no pose from one reading alone."""
        return Poses(None, self.docked, self.staging)

    @property
    def docked(self) -> Pose | None:
        """Where base_link is when docked, in odom."""
        position, axis = self.beacon.position, self.beacon.axis
        return None if position is None or axis is None else self.dock.docked(Pose(position.x, position.y, axis))

    @property
    def seen_at(self) -> float:
        """When the beacon was seen last."""
        return self.beacon.seen_at

    def observe(self, observation: Observation) -> None:
        """Keep up with the beacon and the robot.

        Raises:
            InfraredLost: The receivers have fallen silent.
        """
        self.beacon.update(observation)
        if self._needed and observation.now - self.beacon.heard_at > self._detection_timeout:
            raise InfraredLost(
                f"the receivers were silent for {self._detection_timeout:g} s (external_detection_timeout)"
            )
        super().observe(observation)

    def controller(self, stage: Stage) -> Behavior:
        """A new one for a stage."""
        self._needed = stage in {Stage.NAV_TO_STAGING_POSE, Stage.CONTROLLING}
        if stage is Stage.INITIAL_PERCEPTION:
            return Sequence(self._search, self._scan)
        if stage is Stage.NAV_TO_STAGING_POSE:
            return Sequence(self._sidestep, self._to_staging, self._scan)
        if stage is Stage.CONTROLLING:
            return Sequence(lambda: self._approach(LAST_LOOK), self._scan, self._approach)
        if stage is Stage.RETRY:
            return self.back_off()
        return WaitForCharge(self)

    def _search(self) -> Search:
        beacon, robot = self.beacon, self._robot
        self.beacon.count = 0
        return Search(
            self.motion,
            self._search_speed,
            sees=lambda now: now - beacon.seen_at <= FRESH,
            knows=lambda: beacon.count >= ENOUGH,
            towards=None if beacon.position is None or robot is None else beacon.line_of_sight(robot),
        )

    def _scan(self) -> Scan:
        return Scan(self.beacon, self.motion)

    def _sidestep(self) -> Sidestep:
        side, self._side = self._side, -self._side
        return Sidestep(self.beacon, self.motion, side)

    def _to_staging(self) -> ToStaging:
        return ToStaging(self, self.dock, self.motion)

    def _approach(self, until: float = -math.inf) -> Approach:
        return Approach(self, self.motion, self.lost, self._detection_timeout, until=until)
