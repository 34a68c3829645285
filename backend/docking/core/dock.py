"""The dock as the robot is to use it: where base_link stands when docked, and where it waits in front."""

from dataclasses import dataclass

from docking.core.geometry import Pose


@dataclass(frozen=True, slots=True)
class Dock:
    """Lengths in m, angles in rad; the names are nav2's.

    Attributes:
        external_detection_translation_x: From the marker to the docked base_link, along the marker's x axis, which
            points into the dock; negative, as the robot stands in front of it.
        external_detection_translation_y: The same along its y axis, to the left of it.
        external_detection_rotation_yaw: How the docked robot is turned against the marker's x axis.
        staging_x_offset: From the docked base_link to the staging pose along its x axis; negative is in front.
    """

    external_detection_translation_x: float = -0.20
    external_detection_translation_y: float = 0.0
    external_detection_rotation_yaw: float = 0.0
    staging_x_offset: float = -0.70

    def docked(self, marker: Pose) -> Pose:
        """Where base_link is when docked, in the frame that the marker's pose is given in."""
        return marker.compose(
            Pose(
                self.external_detection_translation_x,
                self.external_detection_translation_y,
                self.external_detection_rotation_yaw,
            )
        )

    def staging(self, docked: Pose) -> Pose:
        """Where base_link waits in front of the dock, turned towards it."""
        return docked.compose(Pose(self.staging_x_offset))
