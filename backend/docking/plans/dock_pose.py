"""The controller `dock_pose`: drives by the pose of a marker on the dock."""

import math
from dataclasses import replace

from docking.behaviors.approach import Approach, sure_enough
from docking.behaviors.combined import Reversed, Sequence
from docking.behaviors.look_around import LookAround
from docking.behaviors.search import Search
from docking.behaviors.staging import ToStaging
from docking.behaviors.turns import FullTurn, TurnToDock
from docking.behaviors.wait_for_charge import WaitForCharge
from docking.core.errors import DockingError, FailedToDetectDock, LostMarker, Stage
from docking.core.geometry import Pose
from docking.core.observation import Observation
from docking.estimation.dock_estimate import DockEstimate, Spread
from docking.estimation.marker_selection import NEAR
from docking.goal.behavior import Behavior, Fail
from docking.goal.plan import KnownPoses, NothingLeftToTry
from docking.parameters import DockSettings, MotionLimits
from docking.plans.camera_correction import CameraCorrection
from docking.plans.sighted import SightedPlan

ENOUGH = Spread(0.05, math.radians(5.0))
"""How well the docked pose must be known before the robot drives."""
IN_VIEW = 0.4
"""How old the last detection may be, in s, for the marker to be in view."""
MISSED = 4.0
"""The same in usual periods between two detections, if that is longer."""
RARE = 2.5
"""The same in s, while it is not known how often the marker is detected."""
TURNS = (0.0, math.radians(3.5), math.radians(-3.5))
"""How far the marker may be turned on its dock, in rad: tried one after another after arrivals without a charge.

If the marker is not turned, each of them still leads onto the contacts.
"""
MOST_DOUBTS = 3
"""How often the marker may not move as the robot drives, before the goal is given up."""
DOUBTED_FOR = 6.0
"""How long the robot waits for another image then, in s."""
WORTH_A_NOTE = 0.2
"""The lag of detections, in s, from which it is noted."""
MEMORY = 1.0
"""How old a detection may be, in s, to be used at all."""


class MarkerDoubted(LostMarker):
    """The marker does not move as the robot drives: to drive on or back would be blind."""

    worth_a_retry = False


class DockPosePlan(SightedPlan):
    """Finds the marker, drives to the staging pose in front of it, then along a smooth curve onto the dock."""

    lost: type[DockingError] = LostMarker
    sensors = frozenset({"odometry", "marker"})

    def __init__(self, settings: DockSettings) -> None:
        """Start with no estimate of the dock.

        Args:
            settings: See `SightedPlan`.
        """
        super().__init__(settings)
        self.marker = DockEstimate(MEMORY)
        self._last_marker: Pose | None = None  # where it was before the robot began to look for it again
        self._looks: Search | None = None
        self._turns = sorted(TURNS, key=lambda turn: turn != settings.last_turn)  # the last one first
        self._observed_at = self._doubted_since = math.inf
        self._turn = 0  # which one of them is tried
        self._waits = self._charged = False
        self._dock_charges = settings.charging.charges
        self._camera = CameraCorrection(settings.last_camera)
        self._missed = False
        if self._camera.reason:
            self.doubts.note("camera", self._camera.reason)

    @property
    def poses(self) -> KnownPoses:
        """The poses that are known."""
        raw, docked, dock = self.marker.raw, self.docked, self.dock
        return KnownPoses(
            None if raw is None else dock.base_link(dock.docked(raw)),
            None if docked is None else dock.base_link(docked),
            None if docked is None else dock.base_link_at_staging(docked),
            self._note,
            self.explores,
            self._turns[self._turn],
            self._camera.kept,
            self.pushes,
            doubt=self.marker.motion.doubt,
            proven=self.marker.motion.proven or not self._sees(self._observed_at),
            late=self.marker.motion.latest - self.marker.motion.lag,
        )

    @property
    def _note(self) -> str:
        """A note that other markers are detected, or that the dock's seems to be turned."""
        selection, known = self.marker.selection, self.marker.pose or self._expected_marker()
        other, turn = selection.other, self._turns[self._turn]
        if other is not None and known is not None:
            return (
                f"another marker is detected {other.distance_to(known):.1f} m from"
                f" {'that of the dock' if self.marker.pose else 'where the dock is expected'}:"
                f" {selection.left_out} detections were left out"
            )
        if turn != 0.0:
            return (
                f"it did not charge, so that the marker is taken to be turned by {math.degrees(turn):.1f} degrees"
                " on its dock: put the robot on its dock and call calibrate_dock"
            )
        return ""

    @property
    def expected(self) -> Pose | None:
        """The pose where the robot should dock, looking into the dock, in odom; None where nothing tells."""
        return super().expected if self._last_marker is None else self.docked or self.dock.docked(self._last_marker)

    def _expected_marker(self) -> Pose | None:
        """Return where the dock's marker should be, in odom."""
        expected = self.expected
        return None if expected is None else expected.compose(self.dock.docked(Pose()).inverse())

    @property
    def _is_certain(self) -> bool:
        return self._last_marker is not None or super()._is_certain

    def _prefer_last(self) -> None:
        """Of two markers take the one where the robot docked last, if there is one of them."""
        two, expected = self.marker.selection.ambiguous, self._expected_marker()
        if two is not None and expected is not None:
            near = [one for one in two if one.distance_to(expected) <= NEAR]
            if len(near) == 1:
                self.marker.selection.expect(near[0])

    def _expect(self) -> None:
        """Say which marker is the dock's, if more than one is detected."""
        if not self._is_certain:
            return
        looked_around = self._looks is not None and self._looks.looked_around
        farthest = self._where.dock_pose_tolerance if self._in_database is not None else math.inf
        self.marker.selection.expect(self._expected_marker(), farthest if looked_around else NEAR)

    @property
    def docked(self) -> Pose | None:
        """The docked pose, looking into the dock, in odom."""
        marker = self.marker.pose
        return None if marker is None else self.dock.docked(marker.compose(Pose(theta=self._turns[self._turn])))

    def observe(self, observation: Observation) -> None:
        """Keep up with the marker and the robot.

        Raises:
            FailedToDetectDock: Nothing tells which of two markers is the dock's.
            MarkerDoubted: The marker does not move as the robot drives.
        """
        if self.pushes:
            self.marker.motion.begin()  # wheels that push may slip
        super().observe(observation)
        self._observed_at = observation.now
        self._charged |= observation.battery is not None and observation.battery.connected
        if self.marker.pose is None:
            self._expect()
        self.marker.update(self._camera.correct(observation))
        if self._missed:
            self._camera.add(self.marker.raw, self.marker.noticed_at, self._robot)
        self._watch_motion(observation.now)
        self._prefer_last()
        if self.marker.pose is None and (two := self.marker.selection.ambiguous) is not None:
            raise FailedToDetectDock(
                f"two markers are detected, {two[0].distance_to(two[1]):.1f} m from each other, and nothing tells which"
                " one is the dock's: give the dock a pose in the database, with tf from its frame to odometry's, or let"
                " the detector publish the dock's marker alone"
            )

    def _watch_motion(self, now: float) -> None:
        """Give the goal up where the marker does not move as the robot drives, and no other image comes."""
        motion = self.marker.motion
        if motion.lag >= WORTH_A_NOTE:
            self.doubts.note("lag", f"detections are about {motion.lag:.1f} s older than their stamps")
        if not motion.doubt:
            self._doubted_since = math.inf
            return
        if self._doubted_since == math.inf:
            self._doubted_since = now
            self.doubts.count("seen motion", motion.doubt)
        if motion.doubts > MOST_DOUBTS or now - self._doubted_since > max(DOUBTED_FOR, self._detection_timeout):
            raise MarkerDoubted(motion.doubt)

    def controller(self, stage: Stage) -> Behavior:
        """A new one for a stage."""
        self.begin()
        waits = stage is Stage.WAIT_FOR_CHARGE and self._dock_charges
        missed, self._waits = self._waits and not self._charged, waits
        if stage is Stage.CONTROLLING:
            self._charged = False
        if stage is Stage.RETRY:
            back_off = self.back_off()
            if not missed:
                return back_off
            first, self._missed = not self._missed, True
            if self.dock.rotate_to_dock:
                return back_off
            back_off, looks = self._turn_on(back_off), first and "marker" in self.sensors
            return Sequence(lambda: back_off, self._look_around, self._conclude) if looks else back_off
        sees_ahead = stage in {Stage.INITIAL_PERCEPTION, Stage.NAV_TO_STAGING_POSE} and self.dock.rotate_to_dock
        controller = self._forwards(stage)
        return Reversed(controller) if self.dock.backward and not sees_ahead else controller

    def _look_around(self) -> Behavior:
        """See whether the camera is where it is taken to be: the robot has touched the dock beside its contacts."""
        return LookAround(self.motion, self._camera.knows)

    def _conclude(self) -> Behavior:
        """Correct what the miss came from, where that shows."""
        try:
            corrects = self._camera.conclude()
        except NothingLeftToTry as failure:
            return Fail(failure)
        if corrects:
            self.doubts.note("camera", self._camera.reason)
            self._turn = 0
        return Sequence()

    def _turn_on(self, back_off: Behavior) -> Behavior:
        """Try another place after the robot has arrived without a charge: never the same one twice."""
        self._turn += 1
        if self._turn < len(self._turns):
            return back_off
        self._turn = 0
        return Fail(
            NothingLeftToTry(
                f"it did not charge turned by {math.degrees(TURNS[1]):.1f} degrees to either side either. If the"
                " charger works, the contacts may be beside where external_detection_translation_y and"
                " external_detection_rotation_yaw have them: put the robot on its dock and call calibrate_dock"
            )
        )

    def _forwards(self, stage: Stage) -> Behavior:
        """Return the behavior of a stage, for a robot that docks forwards."""
        if stage is Stage.INITIAL_PERCEPTION:
            self._last_marker = self.marker.pose or self._last_marker
            self.marker.forget()
            return Sequence(lambda: self.explore(self._search, self._sees))
        if stage is Stage.NAV_TO_STAGING_POSE:
            return self._to_staging()
        if stage is Stage.CONTROLLING:
            return self._approach()
        return WaitForCharge(self)

    @property
    def spread(self) -> Spread:
        """The spread of the docked pose."""
        return self.marker.spread(self.dock.docked(Pose()))

    @property
    def yaw_bias(self) -> float:
        """The curvature of the way, in rad/m, that odometry does not see; backwards it bends to the other side."""
        return -self.marker.yaw_bias if self.dock.backward else self.marker.yaw_bias

    @property
    def disputed(self) -> bool:
        """Whether the last detections agree on another place."""
        return self.marker.disputed

    @property
    def period(self) -> float:
        """Seconds between two detections, usually."""
        return self.marker.period

    @property
    def seen_at(self) -> float:
        """The time when the marker was seen last."""
        return self.marker.seen_at

    def _to_staging(self) -> Behavior:
        if not self.dock.rotate_to_dock:
            return ToStaging(self, self.dock, self.motion)
        # The robot has to know there what it would otherwise learn on the way: where the dock is, and how much odometry
        # misjudges half a turn, which a full turn tells.
        return Sequence(
            lambda: ToStaging(self, self.dock, self.motion),
            lambda: FullTurn(self.motion),
            lambda: ToStaging(self, self.dock, self.motion, sure_enough(self.approach)),
            self._check,
        )

    def _check(self) -> Behavior:
        if not self._knows():
            return Fail(self.lost("the dock was not seen again after a full turn"))
        return self._conclude() if self._missed else Sequence()

    @property
    def _motion_onto(self) -> MotionLimits:
        """The limits on the way onto the dock."""
        return replace(self.motion, v_linear_max=self.motion.v_linear_back) if self.dock.backward else self.motion

    def _approach(self) -> Behavior:
        motion, settings = self._motion_onto, self.approach
        if not self.dock.rotate_to_dock:
            return self.push_on(lambda: Approach(self, motion, settings, self.lost, self._detection_timeout))
        blind = replace(settings, blind_distance=math.inf, look_timeout=0.0)
        return Sequence(
            lambda: TurnToDock(self, motion),
            lambda: self.push_on(lambda: Approach(self, motion, blind, self.lost, self._detection_timeout)),
        )

    def _search(self) -> Search:
        marker, robot = self._expected_marker(), self._robot
        towards = None if marker is None or robot is None else math.atan2(marker.y - robot.y, marker.x - robot.x)
        self._looks = Search(
            self.motion, self._search_speed, sees=self._sees, knows=self._knows, towards=towards, bearing=self._bearing
        )
        return self._looks

    def _sees(self, now: float) -> bool:
        period = self.marker.period
        return now - self.marker.noticed_at <= (max(IN_VIEW, MISSED * period) if period > 0.0 else RARE)

    def _knows(self) -> bool:
        return self.spread.within(ENOUGH)

    def _bearing(self, robot: Pose) -> float | None:
        """Return where to look for the marker that was noticed, in rad to the left."""
        seen = self.marker.raw
        return None if seen is None else math.atan2(seen.y - robot.y, seen.x - robot.x) - robot.theta
