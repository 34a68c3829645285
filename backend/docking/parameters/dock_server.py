"""The parameters of the docking action server."""

from dataclasses import dataclass, field, replace
from typing import Self

from docking.core.errors import DockNotValid
from docking.core.geometry import Pose
from docking.core.parameter import group, number, string
from docking.parameters.approach import ApproachSettings
from docking.parameters.charging import ChargingSource
from docking.parameters.controller import ControllerName, check_controller
from docking.parameters.detector import DetectorSettings
from docking.parameters.dock import Dock, DockType, detection_timeout_field
from docking.parameters.dock_database import DockDatabase, DockEntry
from docking.parameters.limits import BACKWARDS, DriveModel
from docking.parameters.navigation import NavigationSettings, StagingGoal
from docking.parameters.receivers import Receivers
from docking.parameters.recovery import RecoverySettings
from docking.parameters.search import DockPlace, SearchSettings
from docking.parameters.server import ServerSettings, find_disorder, find_shortage
from docking.parameters.stall import StallSettings
from docking.parameters.timeouts import SPEED, DockTimeouts, at_least
from robot_io.transform import Transform

TUTORIAL_PERIOD = 0.1
LONGEST_PRESS = 40.0
"""In s: how long a press beside the last one may take, with the way back before it."""


@dataclass(frozen=True)
class DockSettings(ServerSettings):
    """The parameters of the docking action server."""

    timeouts: DockTimeouts = group(DockTimeouts)
    controller: str = string(
        ControllerName.ROTATE.value,
        "rotate, dock_pose, infrared, …",
        "How the robot is driven: turning on the spot as in the tutorial, by the pose of a marker on the "
        "dock, by three infrared receivers, or by another package's controller. Of the parameters about motion, rotate "
        "uses rotate_speed alone.",
        check_controller,
    )
    rotate_speed: float = number(
        0.15,
        -2.0,
        2.0,
        "rad/s",
        "Angular velocity of the controller rotate (angular.z); counter-clockwise is positive.",
    )
    search_speed: float = number(
        0.6, 0.05, 4.0, "rad/s", "Angular velocity while the robot searches for the dock. Not below v_angular_min."
    )
    external_detection_timeout: float = detection_timeout_field()
    stall: StallSettings = group(StallSettings)
    detector: DetectorSettings = group(DetectorSettings)
    dock: Dock = group(Dock)
    database: DockDatabase = group(DockDatabase)
    navigation: NavigationSettings = group(NavigationSettings)
    search: SearchSettings = group(SearchSettings)
    approach: ApproachSettings = group(ApproachSettings)
    recovery: RecoverySettings = group(RecoverySettings)
    receivers: Receivers = group(Receivers)

    # No parameters, but what `at_dock` finds out of the dock that a goal names.
    dock_type: str = ""
    dock_name: str = ""
    last_docked: Pose | None = None  # where the robot was docked the last time, looking into the dock, in odom
    last_turn: float = 0.0  # how far the dock's marker was taken to be turned then, in rad
    last_camera: Pose = field(default_factory=Pose)  # how far the camera was from where tf has it then, in base_link

    @property
    def goal_timeouts(self) -> DockTimeouts:
        """The time limits of a goal with this controller: none is shorter than its way takes."""
        timeouts, motion, dock = self.timeouts, self.motion, self.dock
        if self.controller == ControllerName.ROTATE:
            return replace(timeouts, charge_stable_for=0.0)
        if self.controller not in {ControllerName.DOCK_POSE, ControllerName.INFRARED}:
            return timeouts
        return replace(
            timeouts,
            staging_timeout=timeouts.staging_timeout * max(1.0, SPEED / motion.v_linear_max),
            dock_approach_timeout=at_least(timeouts.dock_approach_timeout, self._onto(dock)[0]),
            retry_timeout=at_least(timeouts.retry_timeout, dock.distance / motion.v_linear_back),
        )

    def _onto(self, dock: Dock) -> tuple[float, str]:
        """The seconds that the way from the staging pose onto a dock takes, and the way as a part of a sentence."""
        motion, slow = self.motion, min(dock.distance, self.approach.slowdown_radius)
        fast = dock.distance - slow
        speed = motion.v_linear_back if dock.backward else motion.v_linear_max
        where = (
            f"{fast:.3g} m at {speed:.3g} m/s ({f'{BACKWARDS:g} of ' if dock.backward else ''}v_linear_max)"
            f" and {slow:g} m at {motion.v_linear_min:g} m/s (v_linear_min)"
        )
        return fast / speed + slow / motion.v_linear_min, where

    @property
    def control_period(self) -> float:
        """Seconds between two velocities; `rotate` gives ten a second, as the tutorial does."""
        return TUTORIAL_PERIOD if self.controller == ControllerName.ROTATE else super().control_period

    @property
    def dock_types(self) -> tuple[str, ...]:
        """The types of docks, by name."""
        return self.database.dock_plugins

    @property
    def marker_tilt(self) -> Transform:
        """The tilt of the marker, by the parameters of the dock."""
        return self.dock.tilt

    @property
    def joints(self) -> tuple[str, ...]:
        """The joints that stall detection watches."""
        return self.stall.joints

    @property
    def switched(self) -> DetectorSettings:
        """The settings that switch the detector of the dock on and off."""
        return self.detector

    def at_dock(self, name: str) -> Self:
        """The settings for a goal; see `ServerSettings`."""
        database = self.database
        known, entry, kind = database.locate(name)
        dock = database.types.get(kind)
        place = None if entry is None else _place_of(known, entry)
        choices = self._places if database.is_nearest(name) else ()
        staging = self._find_staging(dock or self.dock, place)
        settings = self if dock is None else self._of_type(dock)
        if settings.by_localization:
            if place is None and not choices:
                raise DockNotValid(
                    f"the dock {known or name or '(the only one)'!r:.80} has no pose in the database, by which a robot"
                    " docks that detects no dock (use_external_detection_pose is false)"
                )
            longest = max(self.recovery.correction_timeout, LONGEST_PRESS)
            presses = replace(self.recovery, max_corrections=self.recovery.max_presses, correction_timeout=longest)
            settings = replace(settings, recovery=presses)
        return replace(settings, dock_type=kind, dock_name=known, staging_goal=staging, place=place, choices=choices)

    @property
    def _places(self) -> tuple[DockPlace, ...]:
        """The docks whose poses are known."""
        places = (_place_of(name, self.database.entries[name]) for name in self.database.located)
        return tuple(place for place in places if place is not None)

    @property
    def by_localization(self) -> bool:
        """Whether goals go by the pose in the database and the localization alone."""
        return self._is_blind(self.dock)

    def _is_blind(self, dock: Dock) -> bool:
        return self.controller == ControllerName.DOCK_POSE and not dock.use_external_detection_pose

    @property
    def _kinds(self) -> "dict[str, DockSettings | DockType]":
        """The settings that depend on the type of a dock, by the prefix of its parameters."""
        return {"": self, **{f"{name}.": kind for name, kind in self.database.types.items()}}

    def _of_type(self, dock: DockType) -> Self:
        """With what depends on the type of a dock."""
        return replace(
            self,
            dock=dock,
            charging=dock.charging,
            external_detection_timeout=dock.external_detection_timeout,
            stall=dock.stall,
            detector=dock.detector,
            approach=replace(self.approach, docking_threshold=dock.docking_threshold, final_push=dock.final_push),
        )

    @property
    def navigates(self) -> bool:
        """Whether goals may begin with a navigation to the staging pose; rotate drives to no dock."""
        return self.navigation.navigate_to_staging_pose and self.controller != ControllerName.ROTATE

    def _find_staging(self, dock: Dock, place: DockPlace | None) -> StagingGoal | None:
        if place is None or not self.navigates:
            return None
        return StagingGoal(place.dock, place.frame, dock.brought_to(place.pose), self.navigation)

    def find_conflict(self) -> str | None:
        """Return why these values cannot work together."""
        receivers, motion = self.receivers, self.motion
        conflict = super().find_conflict() or find_disorder(
            "infrared_field_of_view",
            receivers.infrared_field_of_view,
            "infrared_receiver_angle",
            receivers.infrared_receiver_angle,
        )
        if conflict is None and receivers.infrared_distance_max < receivers.infrared_distance_min + 0.1:
            conflict = (
                f"infrared_distance_max ({receivers.infrared_distance_max:g} m) must be at least 0.1 m above"
                f" infrared_distance_min ({receivers.infrared_distance_min:g} m)"
            )
        if motion.motion_model is DriveModel.ACKERMANN:
            conflict = conflict or (
                "motion_model is 'Ackermann', but docking turns on the spot, which such a base cannot: dock it with a"
                " planner that knows its turning radius, such as nav2's docking server with a plugin of your own"
            )
        conflict = conflict or self._find_unnamed_joints()
        for prefix, kind in self._kinds.items() if self.controller == ControllerName.ROTATE else ():
            if kind.charging.by_pose:
                source = f"{prefix}charging_source is {kind.charging.charging_source.value!r}"
                conflict = conflict or f"{source}, but the controller rotate knows no docked pose"
        conflict = conflict or self.database.find_fault() or self._find_blind_judge()
        if conflict is not None or self.controller not in {ControllerName.DOCK_POSE, ControllerName.INFRARED}:
            return conflict
        for dock in (self.dock, *self.database.types.values()):
            conflict = conflict or self._find_fault(dock)
        return conflict or find_disorder("search_speed", self.search_speed, "v_angular_min", motion.v_angular_min)

    def _find_blind_judge(self) -> str | None:
        """A dock that nothing sees, where the pose alone is to tell that the battery charges."""
        for prefix, kind in self._kinds.items():
            dock = self.dock if isinstance(kind, DockSettings) else kind
            used = prefix or not self.database.types
            if used and self._is_blind(dock) and kind.charging.charging_source is ChargingSource.POSE:
                return (
                    f"{prefix}charging_source is 'pose', but with {prefix}use_external_detection_pose false the pose is"
                    " known to some centimetres only: status or current has to tell that the battery charges"
                )
        return None

    def _find_unnamed_joints(self) -> str | None:
        for prefix, kind in self._kinds.items():
            if kind.stall.use_stall_detection and not kind.stall.stall_joint_names:
                return f"{prefix}use_stall_detection is true, but {prefix}stall_joint_names is empty"
        return None

    def _find_fault(self, dock: Dock) -> str | None:
        if dock.rotate_to_dock and not dock.backward:
            return "rotate_to_dock is true, but dock_direction is not backward"
        if dock.backward and self.controller == ControllerName.INFRARED:
            return "dock_direction is backward, but infrared docks forwards only: its receivers look ahead"
        timeouts, (approach, where) = self.timeouts, self._onto(dock)
        return find_shortage(
            "dock_approach_timeout", timeouts.dock_approach_timeout, approach, where
        ) or self.find_backing_shortage("retry_timeout", timeouts.retry_timeout, dock.distance)


def _place_of(name: str, entry: DockEntry) -> DockPlace | None:
    """Return where the database has a dock; None where it says nothing about that."""
    return DockPlace(name, entry.frame, Pose(*entry.pose)) if entry.pose else None
