"""Parameters of the docked pose and the staging pose."""

import enum
import math
from dataclasses import dataclass

from docking.core.geometry import Pose
from docking.core.parameter import choice, group, number, switch
from docking.core.transform import tilt
from docking.parameters.approach import push_field, threshold_field
from docking.parameters.charging import ChargingSettings
from docking.parameters.detector import DetectorSettings
from docking.parameters.stall import StallSettings
from robot_io.transform import Transform


class DockDirection(enum.StrEnum):
    """The end of the robot that comes to the dock."""

    FORWARD = "forward"
    BACKWARD = "backward"


@dataclass(frozen=True, slots=True)
class Staging:
    """Parameters of the staging pose."""

    staging_x_offset: float = number(
        -0.7,
        -3.0,
        -0.3,
        "m",
        "Distance from the docked pose to the staging pose along the dock's axis; negative is in front of the dock.",
    )

    dock_direction: DockDirection = choice(
        DockDirection.FORWARD,
        "Whether the robot drives onto the dock forwards or backwards; it undocks the other way. If backwards, what "
        "detects the marker must look back, too; if it looks ahead, set rotate_to_dock.",
    )

    @property
    def backward(self) -> bool:
        """Whether the robot's back comes to the dock."""
        return self.dock_direction is DockDirection.BACKWARD

    @property
    def distance(self) -> float:
        """Between the docked pose and the staging pose, in m."""
        return -self.staging_x_offset

    def staging(self, docked: Pose) -> Pose:
        """Return the pose in front of the dock where the robot waits; its docking end is turned towards it."""
        return docked.compose(Pose(self.staging_x_offset))

    def base_link(self, docked: Pose) -> Pose:
        """base_link where the robot's end that comes to the dock is turned like this pose."""
        return docked.compose(Pose(theta=math.pi)) if self.backward else docked


@dataclass(frozen=True, slots=True)
class Dock(Staging):
    """Parameters of base_link's docked pose and the pose in front, where it waits. The names are nav2's."""

    external_detection_translation_x: float = number(
        -0.2,
        -2.0,
        0.0,
        "m",
        "Position of the docked robot relative to the marker or the beacon, along the axis of the dock, which points "
        "into it: the marker's x axis, turned by external_detection_rotation_yaw.",
    )
    external_detection_translation_y: float = number(0.0, -1.0, 1.0, "m", "The same, to the left of that axis.")
    external_detection_rotation_roll: float = number(
        0.0,
        -3.1416,
        3.1416,
        "rad",
        "Turn of the marker's axes about its x axis, after external_detection_rotation_pitch, that makes x point into "
        "the dock and z up: -1.57 for AprilTags whose z axis points out of the tag.",
    )
    external_detection_rotation_pitch: float = number(
        0.0, -3.1416, 3.1416, "rad", "The same about its y axis, before the roll: 1.57 for these AprilTags."
    )
    external_detection_rotation_yaw: float = number(
        0.0,
        -3.1416,
        3.1416,
        "rad",
        "Heading of the docked robot, as it looks into the dock, relative to the marker's x axis.",
    )

    use_external_detection_pose: bool = switch(
        True,
        "Whether the dock is detected (detected_dock_pose). If not, dock_pose drives by the dock's pose in the "
        "database and the localization in its frame (tf) alone, and feels for the contacts until the battery charges.",
    )

    rotate_to_dock: bool = switch(
        False,
        "Whether the robot detects the dock forwards, then turns round at the staging pose and backs onto the dock by "
        "odometry alone. Only if dock_direction is `backward`.",
    )

    staging_yaw_offset: float = number(
        0.0,
        -3.1416,
        3.1416,
        "rad",
        "Heading with which navigate_to_pose brings the robot to the staging pose, relative to the dock's axis; 0: as "
        "dock_direction and rotate_to_dock ask for. Only with navigate_to_staging_pose.",
    )

    def base_link_at_staging(self, docked: Pose) -> Pose:
        """base_link at the staging pose: a robot that turns round there comes looking into the dock."""
        staging = self.staging(docked)
        return staging if self.rotate_to_dock else self.base_link(staging)

    def brought_to(self, docked: Pose) -> Pose:
        """base_link where navigate_to_pose brings the robot."""
        if self.staging_yaw_offset:
            return self.staging(docked).compose(Pose(theta=self.staging_yaw_offset))
        return self.base_link_at_staging(docked)

    @property
    def tilt(self) -> Transform:
        """The marker's frame, x into the dock and z up, as seen from that of its detections."""
        return tilt(self.external_detection_rotation_roll, self.external_detection_rotation_pitch)

    def docked(self, marker: Pose) -> Pose:
        """Return the docked pose, looking into the dock, in the frame that the marker's pose is given in.

        A robot that docks backwards looks the other way: see base_link.
        """
        position = Pose(self.external_detection_translation_x, self.external_detection_translation_y)
        return marker.compose(Pose(theta=self.external_detection_rotation_yaw)).compose(position)

    @staticmethod
    def offset(docked: Pose) -> Pose:
        """The translation and the yaw that `docked` gets the pose of a docked robot with, in the marker's frame."""
        position = Pose(theta=-docked.theta).compose(Pose(docked.x, docked.y))
        return Pose(position.x, position.y, docked.theta)


def detection_timeout_field() -> float:
    """The field for the time without a detection after which the dock is lost."""
    return number(
        2.0,
        0.1,
        60.0,
        "s",
        "Time without a detection of the marker or the beacon, during the approach, after which the dock is lost.",
    )


@dataclass(frozen=True, slots=True)
class DockType(Dock):
    """All that can be set for a type of docks."""

    charging: ChargingSettings = group(ChargingSettings)
    external_detection_timeout: float = detection_timeout_field()
    docking_threshold: float = threshold_field()
    final_push: float = push_field()
    stall: StallSettings = group(StallSettings)
    detector: DetectorSettings = group(DetectorSettings)
