"""Parameters that keep the robot away from obstacles."""

from dataclasses import dataclass

from docking.core.footprint import ROBOT_RADIUS, Footprint, read_footprint, round_footprint
from docking.core.geometry import Pose
from docking.core.parameter import number, string, switch


@dataclass(frozen=True, slots=True)
class Outline:
    """The robot from above."""

    robot_radius: float = number(
        ROBOT_RADIUS, 0.01, 5.0, "m", "Radius of a round robot, around base_link; for maps and collision detection."
    )
    footprint: str = string(
        "",
        "[[x, y], …]",
        "Outline of a robot that is not round: 3 to 100 points in base_link, in m, in their order around the robot. "
        "If it is empty, robot_radius counts.",
        read_footprint,
    )

    @property
    def points(self) -> Footprint:
        """In base_link."""
        return read_footprint(self.footprint) or round_footprint(self.robot_radius)


@dataclass(frozen=True, slots=True)
class CollisionSettings:
    """Parameters of when the robot slows down, waits and gives up, and of how the laser scanner is mounted."""

    use_collision_detection: bool = switch(
        False,
        "Whether the robot watches its way with a laser scanner (`scan`): it slows down and waits for obstacles, and "
        "does not drive without a scan. Does not apply to rotate.",
    )
    projection_time: float = number(
        2.0,
        0.5,
        10.0,
        "s",
        "Time to the contact with an obstacle from which the robot drives more slowly; at half of it, it stops. Longer "
        "for a base that brakes slowly.",
    )
    obstacle_margin: float = number(0.05, 0.0, 1.0, "m", "Clearance kept around the robot's outline.")
    obstacle_timeout: float = number(
        30.0,
        0.0,
        3600.0,
        "s",
        "Time for which the robot waits for an obstacle, or for a scan, before the goal is aborted.",
    )
    scan_timeout: float = number(0.5, 0.1, 10.0, "s", "Age of the last scan from which the robot stands still.")
    dock_collision_threshold: float = number(
        0.3,
        0.0,
        2.0,
        "m",
        "Distance to the docked pose within which points at the sides of the docked robot, such as guide rails, are "
        "ignored. Points beyond its front are the dock, at any distance.",
    )
    scan_from_tf: bool = switch(
        False, "Whether tf says where the laser scanner is; else scan_x, scan_y and scan_yaw do."
    )
    scan_x: float = number(0.0, -5.0, 5.0, "m", "Position of the laser scanner: x in base_link.")
    scan_y: float = number(0.0, -5.0, 5.0, "m", "The same, y.")
    scan_yaw: float = number(
        0.0, -3.1416, 3.1416, "rad", "Direction of the laser scanner's x axis; 0 is straight ahead."
    )

    @property
    def mount(self) -> Pose | None:
        """The laser scanner in base_link; None where tf says it."""
        return None if self.scan_from_tf else Pose(self.scan_x, self.scan_y, self.scan_yaw)

    @property
    def needs_tf(self) -> bool:
        """Whether tf must be heard."""
        return self.use_collision_detection and self.scan_from_tf
