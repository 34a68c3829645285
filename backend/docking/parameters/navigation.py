"""Parameters of a drive to the staging pose by another action server."""

from dataclasses import dataclass

from docking.core.geometry import Pose
from docking.core.parameter import number, string, switch


@dataclass(frozen=True, slots=True)
class NavigationSettings:
    """Parameters of nav2's drive to the staging pose of a dock that is in the database; the names are nav2's."""

    navigate_to_staging_pose: bool = switch(
        False,
        "Whether the action server navigate_to_pose (nav2) drives the robot to the staging pose of a dock that has a "
        "pose, if it is farther away than dock_prestaging_tolerance. Not for rotate.",
    )
    dock_prestaging_tolerance: float = number(
        0.5,
        0.0,
        100.0,
        "m",
        "Distance from the staging pose within which the robot is not driven there by navigate_to_pose.",
    )
    max_staging_time: float = number(
        1000.0, 1.0, 86400.0, "s", "Time limit for navigate_to_pose to drive the robot to the staging pose."
    )
    navigator_bt_xml: str = string(
        "", "path", "Behavior tree that navigate_to_pose drives with; if it is empty, the one of nav2's configuration."
    )


@dataclass(frozen=True, slots=True)
class StagingGoal:
    """A staging pose that is known before the dock is seen.

    Attributes:
        dock: The name of the dock.
        frame: The frame of the pose, as the database names it.
        pose: Of base_link in front of the dock.
        settings: When to navigate there.
    """

    dock: str
    frame: str
    pose: Pose
    settings: NavigationSettings
