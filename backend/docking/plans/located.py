"""Docking without a detector: the dock's pose in the database, and a localization that says where that is."""

import math
from dataclasses import replace

from docking.behaviors.approach import Approach
from docking.behaviors.combined import Reversed, Sequence
from docking.behaviors.feel import OFFSETS, press_beside
from docking.behaviors.search import Search
from docking.behaviors.straight import GoTo
from docking.behaviors.wait_for_charge import WaitForCharge
from docking.core.errors import FailedToStage, LocalizationLost, Stage
from docking.core.geometry import Pose
from docking.core.observation import MarkerDetection, Observation
from docking.estimation.localization import SteadyLocalization
from docking.goal.behavior import Behavior, Fail
from docking.goal.plan import DockTarget, KnownPoses, NothingLeftToTry
from docking.parameters import ApproachSettings, DockSettings
from docking.plans.dock_pose import DockPosePlan
from docking.plans.places import may_be_seen, way_to_front

LATE = 0.3
"""In m before the docked pose: nearer, the robot drives by odometry, and what the localization says is left out."""
ASSUMED, MOST = 0.1, 0.3
"""How far the pose may be off at least, and how far off is reckoned with at most, in m."""
FARTHEST_BEYOND = 0.12
"""How far beyond the docked pose the robot drives at most, in m, where the pose may be off."""
DEVIATIONS = 2.0
"""Standard deviations of the localization that the pose may be off."""
LOST = 0.5
"""Standard deviation of a localization that does not know where it is, in m."""
FEELS_FOR = 400.0
"""For how long the robot feels for the contacts, in s."""


class StandsHere(DockTarget):
    """The dock where the robot stands: with a pose that may be off, that is as good as any other place."""

    seen_at = math.inf

    def __init__(self, robot: Pose | None) -> None:
        """Start on the dock, or beside it.

        Args:
            robot: Where the robot is, looking into the dock, in odom; None if that is not known.
        """
        self._robot = robot

    @property
    def docked(self) -> Pose | None:
        """The docked pose, looking into the dock."""
        return self._robot


class LocatedPlan(DockPosePlan):
    """Docks as `DockPosePlan` does, with the poses of the localization as detections; then presses beside each other.

    The estimate is kept in odom. A pose that has jumped is not followed before it has lasted, nor near the dock. How
    far the pose may be off decides where the robot drives slowly, and how far it drives on without a contact.
    """

    lost = LocalizationLost
    unseen = "the localization was silent, or did not know where the robot is,"
    sensors = frozenset({"odometry", "localization"})

    def __init__(self, settings: DockSettings) -> None:
        """Start without a pose.

        Args:
            settings: See `SightedPlan`.
        """
        super().__init__(settings)
        self.dock = replace(settings.dock, rotate_to_dock=False)
        self._steady = SteadyLocalization()
        self._error = math.nan  # standard deviation of the localization, in m
        self._now = self._heard_at = -math.inf
        self._late = False
        self._feels_since: float | None = None
        self._pressed = 0

    @property
    def poses(self) -> KnownPoses:
        """The poses that are known."""
        return replace(super().poses, uncertainty=self.uncertainty)

    @property
    def uncertainty(self) -> float:
        """The greatest distance that the docked pose may be off, in m."""
        error = 0.0 if math.isnan(self._error) else DEVIATIONS * self._error
        return min(MOST, max(ASSUMED, error, self._steady.largest))

    @property
    def _note(self) -> str:
        """A note about what the robot does not know."""
        if self.marker.pose is None:
            return (
                f"the localization is lost: its standard deviation is {self._error:.2f} m"
                if self._error > LOST
                else "nothing says where the dock is: a localization has to publish tf to odometry's frame"
            )
        notes = []
        if self._steady.largest > 0.0:
            notes.append(f"the localization jumped by up to {self._steady.largest:.2f} m")
        if self._pressed:
            sides = sorted({round(1000.0 * offset.y) for offset in OFFSETS[: self._pressed]} | {0})
            turn = max(abs(offset.theta) for offset in OFFSETS[: self._pressed])
            notes.append(
                f"without a marker the dock's pose may be off by {self.uncertainty:.2f} m: the robot pressed at"
                f" {self._pressed + 1} places, {', '.join(map(str, sides))} mm to the left and turned by up to"
                f" {math.degrees(turn):.1f} degrees"
            )
        return "; ".join(notes)

    @property
    def expected(self) -> Pose | None:
        """The docked pose by the localization, in odom."""
        return self._in_database

    def observe(self, observation: Observation) -> None:
        """Keep up with the localization and the robot."""
        self._now = observation.now
        detection = self._locate(observation)
        super().observe(replace(observation, marker=detection, other_markers=()))

    def _locate(self, observation: Observation) -> MarkerDetection | None:
        """Return the localization's pose as if a marker were detected there; None while that is not believed."""
        expected, at, odometry = observation.expected_dock, observation.localized_at, observation.odometry
        self._error = observation.localization_error
        if expected is None or odometry is None or self._error > LOST:
            return None
        self._heard_at = max(self._heard_at, at)
        docked = self.docked
        believes = self._steady.believes(expected, docked, observation.now)
        self._late = docked is not None and odometry.pose.distance_to(docked) < LATE
        if self._late or not believes:
            return None
        if self._steady.jumped:
            self.marker.forget()  # it has lasted
        return MarkerDetection(expected.compose(self.dock.docked(Pose()).inverse()), at)

    @property
    def seen_at(self) -> float:
        """The time of the last message of the localization; near the dock it is not needed."""
        return self._now if self._late else self._heard_at

    @property
    def disputed(self) -> bool:
        """Whether the localization has jumped: the robot stands until that is over, or has lasted."""
        return not self._late and (self._steady.jumped or super().disputed)

    def _forwards(self, stage: Stage) -> Behavior:
        if stage is Stage.INITIAL_PERCEPTION:
            return Search(self.motion, self._search_speed, sees=lambda now: True, knows=self._knows)
        if stage is Stage.WAIT_FOR_CHARGE:
            return WaitForCharge(StandsHere(None if self._robot is None else self.dock.base_link(self._robot)))
        return super()._forwards(stage)

    def _turn_on(self, back_off: Behavior) -> Behavior:
        """Return a behavior that tries the same place again: by then the localization may know better."""
        return back_off

    def _to_staging(self) -> Behavior:
        robot, docked = self._robot, self.docked
        if robot is None or docked is None:
            return super()._to_staging()
        staging, radius = self.dock.staging(docked), self._where.known_dock_radius
        if robot.distance_to(staging) > radius:
            return Fail(
                FailedToStage(
                    f"the dock is {robot.distance_to(staging):.1f} m away, farther than known_dock_radius"
                    f" ({radius:g} m): let nav2 drive there (navigate_to_staging_pose)"
                )
            )
        slowly = replace(self.motion, v_linear_max=self.motion.v_linear_back)
        around = [] if may_be_seen(robot, docked) else list(way_to_front(robot, docked, staging))[:-1]
        to_staging = super()._to_staging
        return Sequence(*(lambda place=place: GoTo(place, slowly) for place in around), to_staging)

    @property
    def _loose(self) -> ApproachSettings:
        """Settings to drive onto a dock whose pose may be off."""
        settings, off = self.approach, self.uncertainty
        return replace(
            settings,
            blind_distance=LATE,
            docking_threshold=settings.docking_threshold + off,
            docking_overshoot=settings.docking_overshoot + min(off, FARTHEST_BEYOND),
        )

    def _approach(self) -> Behavior:
        motion = self._motion_onto
        return self.push_on(lambda: Approach(self, motion, self._loose, self.lost, self._detection_timeout))

    def correct(self, number: int) -> Behavior:
        """A press beside the last one; see `RecoveringPlan`."""
        self._feels_since = self._now if self._feels_since is None else self._feels_since
        if number > len(OFFSETS) or self._now - self._feels_since > FEELS_FOR:
            return Fail(NothingLeftToTry(f"the contacts were not felt within {FEELS_FOR:g} s"))
        self._pressed = number
        press = press_beside(
            self, OFFSETS[number - 1], self._motion_onto, self._loose, self.push_on, staging=self.dock.distance
        )
        return Reversed(press) if self.dock.backward else press
