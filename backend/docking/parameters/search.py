"""Parameters of the search for the dock."""

from dataclasses import dataclass

from docking.core.geometry import Pose
from docking.core.parameter import number


@dataclass(frozen=True, slots=True)
class SearchSettings:
    """Parameters of the way on which the robot finds its dock, and of the marker that is believed to be the dock's."""

    search_radius: float = number(
        0.0,
        0.0,
        50.0,
        "m",
        "Distance from its start to which the robot may drive to find a dock whose pose is not known; 0: it only "
        "turns. It drives forwards, but with no map: use it with use_collision_detection.",
    )
    known_dock_radius: float = number(
        8.0,
        0.0,
        100.0,
        "m",
        "Distance from the staging pose of a dock whose pose is known, by the database or since the robot docked "
        "there, from which it drives there to see the dock: straight, but around the dock; 0: it only turns.",
    )
    search_timeout: float = number(
        300.0, 1.0, 3600.0, "s", "Time limit for driving about to find the dock, after initial_perception_timeout."
    )
    dock_pose_tolerance: float = number(
        1.0,
        0.1,
        100.0,
        "m",
        "Distance from where the database has the dock within which a marker may be that of the dock; the nearest one "
        "is taken.",
    )


@dataclass(frozen=True, slots=True)
class DockPlace:
    """The pose of a dock in the database.

    Attributes:
        dock: The name of the dock.
        frame: The frame of the pose, as the database names it.
        pose: Of the docked robot, looking into the dock.
    """

    dock: str
    frame: str
    pose: Pose
