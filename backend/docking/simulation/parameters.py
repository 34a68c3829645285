"""The parameters of the node `dock_simulator`: those of the model, and those of the node."""

import enum
from dataclasses import dataclass

from docking.core.parameter import NodeSettings, choice, group, number, string, switch
from docking.parameters import read_topics
from docking.simulation.settings import Settings


class BaseFrame(enum.StrEnum):
    """The frame whose pose odometry tells."""

    BASE = "base_link"
    FOOTPRINT = "base_footprint"


class DetectionFrame(enum.StrEnum):
    """The frame that detections of the marker are given in."""

    BASE = "base_link"
    CAMERA = "camera_optical_frame"


@dataclass(frozen=True)
class SimulatorSettings(NodeSettings):
    """The parameters of the node."""

    real_time_factor: float = number(
        1.0,
        0.1,
        100.0,
        "",
        "Simulated seconds per second. Controllers expect 1, as they use the real clock.",
    )
    publish_clock: bool = switch(
        False,
        "Whether the simulator has a clock of its own, which slows down where the machine is too slow; it is published "
        "on /clock, for docking servers with use_sim_time. Applies at the next start.",
    )
    battery_resume_after: float = number(
        3.0,
        0.0,
        3600.0,
        "s",
        "Time without messages of other nodes on battery_status after which the simulated battery is published again.",
    )
    seed: int = number(0, 0, 2**31 - 1, "", "Seed of the random number generator.")
    enable_stamped_cmd_vel: bool = switch(
        False, "Whether the base subscribes to cmd_vel as TwistStamped; applies at the next start."
    )
    stop_topics: str = string(
        "",
        "topic, topic, …",
        "More topics like stop_latched, separated by commas, which the base obeys; applies at the next start.",
        read_topics,
    )
    odometry_child_frame: BaseFrame = choice(
        BaseFrame.BASE, "The frame whose pose odometry tells; applies at the next start."
    )
    detection_frame: DetectionFrame = choice(
        DetectionFrame.BASE, "The frame of detected_dock_pose; applies at the next start."
    )
    room: bool = switch(
        True,
        "Whether the dock is in a room with walls and furniture; else on an endless floor. Applies at the next start.",
    )
    room_extension: float = number(
        0.0,
        0.0,
        40.0,
        "m",
        "How much longer the room is, to the left of the dock; its end moves along. Applies at the next start.",
    )
    home_dock: int = number(
        1,
        1,
        100,
        "",
        "The dock that true_dock_pose is about: 1 is the first one, 2 the first of `docks`. Applies at the next start.",
    )
    shares_room: bool = switch(
        False,
        "Whether other simulated robots are in the room: each publishes where it is on /simulated_robots, and they "
        "block and see each other. Applies at the next start.",
    )
    publish_map: bool = switch(
        True,
        "Whether the room's `map` is published, and where odometry lies in it, as a localization does; switch it off "
        "for a localization of your own. Applies at the next start.",
    )
    switched_detector: bool = switch(
        False,
        "Whether the camera detects the marker only while the service dock_simulator/detector has switched it on; "
        "applies at the next start.",
    )
    settings: Settings = group(Settings)
