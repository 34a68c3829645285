"""The controller `infrared`: drives by three receivers and a beacon on the dock."""

import math

from docking.behaviors.approach import Approach
from docking.behaviors.combined import Sequence
from docking.behaviors.explore import Explore
from docking.behaviors.moves import bounded
from docking.behaviors.scan import Scan
from docking.behaviors.search import Search
from docking.behaviors.sidestep import Sidestep
from docking.behaviors.staging import ToStaging
from docking.behaviors.straight import BackOut, GoTo
from docking.behaviors.wait_for_charge import WaitForCharge
from docking.core.errors import FailedToControl, InfraredLost, PushedOff, Stage
from docking.core.geometry import Pose
from docking.core.observation import Observation
from docking.estimation.beacon_filter import FRESH, BeaconFilter
from docking.goal.behavior import Behavior, Fail
from docking.goal.plan import KnownPoses
from docking.parameters import DockSettings
from docking.plans.sighted import SightedPlan

ENOUGH = 3
"""Readings that must see the beacon before the robot moves on."""
WELL_SEEN = 0.75
"""From the receivers to the beacon, in m: how far to back off."""
PAUSE = 0.5
"""After a longer time without an observation, in s, the robot has waited: what came meanwhile was not listened to."""


class InfraredPlan(SightedPlan):
    """Finds the beacon, then the edge of its light, and so the dock's axis; along that it drives onto the dock.

    Each retry looks for the other edge: with both, the axis is the better known.
    """

    lost = InfraredLost
    sensors = frozenset({"odometry", "infrared"})

    def __init__(self, settings: DockSettings) -> None:
        """Start with no estimate of the dock.

        Args:
            settings: See `SightedPlan`.
        """
        super().__init__(settings)
        self.beacon = BeaconFilter(settings.receivers)
        self._side = 1
        self._has_axis = False
        self._light: Pose | None = None  # in odom, where the robot has had a good look at the beacon
        self._waiting = self._approaching = False
        self._needed = False  # whether the stage needs the receivers
        self._observed_at = self._listens_since = -math.inf

    @property
    def poses(self) -> KnownPoses:
        """The poses that are known; one reading alone gives none."""
        return KnownPoses(None, self.docked, self.staging, explores=self.explores, pushes=self.pushes)

    @property
    def docked(self) -> Pose | None:
        """The pose of base_link when docked, in odom."""
        position, axis = self.beacon.position, self.beacon.axis
        return None if position is None or axis is None else self.dock.docked(Pose(position.x, position.y, axis))

    @property
    def seen_at(self) -> float:
        """The time when the beacon was seen last."""
        return self.beacon.seen_at

    def observe(self, observation: Observation) -> None:
        """Keep up with the beacon and the robot.

        Raises:
            InfraredLost: The receivers have fallen silent, or the beacon is somewhere else.
            PushedOff: The same on the dock.
        """
        self.beacon.update(observation)
        if observation.now - self._observed_at > PAUSE:
            self._listens_since = observation.now
        self._observed_at = observation.now
        silent = observation.now - max(self.beacon.heard_at, self._listens_since)
        if self._needed and silent > self._detection_timeout:
            what = "repeated one reading, although the robot moves," if self.beacon.repeated.repeats else "were silent"
            raise InfraredLost(f"the receivers {what} for {self._detection_timeout:g} s (external_detection_timeout)")
        had_axis, self._has_axis = self._has_axis, self.beacon.axis is not None
        if had_axis and not self._has_axis and self._needed:
            raise InfraredLost("the beacon is not where it was")
        if had_axis and not self._has_axis and self._waiting:
            raise PushedOff("the robot was moved on the dock: the beacon is not where it was")
        super().observe(observation)

    def controller(self, stage: Stage) -> Behavior:
        """A new one for a stage."""
        self.begin()
        if stage is Stage.RETRY and self._approaching and self.beacon.known:
            self.beacon.forget_axis()  # the robot may have been pushed: it looks for the edges of the light again
        self._approaching = stage is Stage.CONTROLLING
        self._waiting = stage is Stage.WAIT_FOR_CHARGE
        self._needed = stage in {Stage.NAV_TO_STAGING_POSE, Stage.CONTROLLING}
        if stage is Stage.INITIAL_PERCEPTION:
            return Sequence(self._return_to_light, self._begin_search, self._scan, self._remember_light)
        if stage is Stage.NAV_TO_STAGING_POSE:
            return self._find_axis()
        if stage is Stage.CONTROLLING:
            return Sequence(self._first_approach, self._scan, self._check_axis, self._onto)
        if stage is Stage.RETRY:
            return self._back_off()
        return WaitForCharge(self)

    def _back_off(self) -> Behavior:
        """Not farther from the beacon than where it is seen well."""
        if self._robot is None or not self.beacon.known:
            return self.back_off()
        return BackOut(bounded(WELL_SEEN - self.beacon.distance(self._robot), -self.dock.staging_x_offset), self.motion)

    def _return_to_light(self) -> Behavior:
        """A retry begins where the beacon is in sight for sure."""
        if self._light is None or self.beacon.lit:
            return Sequence()
        return GoTo(self._light, self.motion)

    def _remember_light(self) -> Behavior:
        self._light = self._robot
        return Sequence()

    def _begin_search(self) -> Explore:
        self.beacon.count = 0
        return self.explore(self._search, self._sees)

    def _search(self) -> Search:
        beacon, robot = self.beacon, self._robot
        towards, expected = None, self.expected
        if robot is not None and beacon.position is not None:
            towards = beacon.line_of_sight(robot)
        elif robot is not None and expected is not None:
            towards = math.atan2(expected.y - robot.y, expected.x - robot.x)
        return Search(
            self.motion, self._search_speed, sees=self._sees, knows=lambda: beacon.count >= ENOUGH, towards=towards
        )

    def _sees(self, now: float) -> bool:
        return now - self.beacon.seen_at <= FRESH

    def _scan(self) -> Scan:
        return Scan(self.beacon, self.motion)

    def _find_axis(self) -> Sequence:
        """By one edge, and by the other one where that is not enough."""
        return Sequence(self._sidestep, self._to_staging, self._scan, self._find_more)

    def _find_more(self) -> Sequence:
        return Sequence() if self._knows_axis() else self._find_axis()

    def _knows_axis(self) -> bool:
        return self.beacon.axis_error <= self.beacon.receivers.infrared_axis_error_max

    def _check_axis(self) -> Behavior:
        if self._knows_axis():
            return Sequence()
        error = math.degrees(self.beacon.axis_error)
        return Fail(FailedToControl(f"the dock's axis is not known well enough: to {error:.1f} degrees"))

    def _sidestep(self) -> Sidestep:
        side, self._side = self._side, -self._side
        return Sidestep(self.beacon, self.motion, side, self._detection_timeout)

    def _to_staging(self) -> ToStaging:
        return ToStaging(self, self.dock, self.motion)

    def _first_approach(self) -> Approach:
        return self._approach(self.beacon.receivers.infrared_last_scan)

    def _onto(self) -> Behavior:
        return self.push_on(self._approach)

    def _approach(self, until: float = -math.inf) -> Approach:
        return Approach(self, self.motion, self.approach, self.lost, self._detection_timeout, until=until)
