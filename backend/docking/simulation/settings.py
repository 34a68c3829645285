"""Everything that can be chosen of the simulation."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from docking.core.geometry import Pose
from docking.core.parameter import group, number, numbers
from docking.simulation.battery import BatterySettings
from docking.simulation.dock import DockSettings
from docking.simulation.infrared import InfraredSettings
from docking.simulation.laser import LaserSettings
from docking.simulation.localization import LocalizationSettings
from docking.simulation.marker import MarkerSettings
from docking.simulation.obstacle import Obstacle
from docking.simulation.odometry import OdometrySettings
from docking.simulation.robot import RobotSettings
from docking.simulation.room import Room

APART = 0.5
"""How far docks must be apart, in m."""


def check_docks(places: Sequence[float]) -> None:
    """Refuse docks that stand in each other.

    Raises:
        ValueError: Two are too near to each other, or far away.
    """
    if not all(abs(place) <= FARTHEST for place in places):
        raise ValueError(f"is {list(places)}, but each must be from -{FARTHEST:g} to {FARTHEST:g} m")
    if any(right - left < APART for left, right in pairwise(sorted((0.0, *places)))):
        raise ValueError(f"is {list(places)}, but docks must be {APART:g} m from each other, and from the one at 0")


FARTHEST = 20.0
"""How far from the first dock another one may be, in m."""


@dataclass(frozen=True, slots=True)
class Start(Pose):
    """Settings of the robot's first pose, in world."""

    x: float = number(-1.5, -20.0, 20.0, "m", "Start pose of the robot in world, x.")
    y: float = number(0.4, -20.0, 20.0, "m", "Start pose, y.")
    theta: float = number(-0.3, -3.15, 3.15, "rad", "Start pose, heading; 0 faces the dock.")


@dataclass(frozen=True, slots=True)
class Settings:
    """Everything that can be chosen.

    Attributes:
        start: Where the robot stands at first, in world.
        electronics_power: Power of the robot while it stands still, in W.
        driving_power: Additional power of its motors at 1 m/s, in W.
        stall_power: Additional power of the motors while a wheel is kept from turning, in W.
        obstacles: Obstacles other than the dock.
        room: The room with the dock; None on an endless floor.
        robot: The robot.
        odometry: Its reckoning.
        marker: Its camera and the dock's marker.
        infrared: Its receivers and the dock's beacon.
        localization: Its localization on the map.
        laser: Its laser scanner.
        battery: Its battery and the dock's charger.
        dock: The dock, and each of the others.
    """

    start: Pose = group(Start, "start_")
    electronics_power: float = 2.5
    driving_power: float = 20.0
    stall_power: float = 6.0
    robot: RobotSettings = group(RobotSettings)
    odometry: OdometrySettings = group(OdometrySettings, "odometry_")
    marker: MarkerSettings = group(MarkerSettings, "marker_")
    infrared: InfraredSettings = group(InfraredSettings, "infrared_")
    localization: LocalizationSettings = group(LocalizationSettings, "localization_")
    laser: LaserSettings = group(LaserSettings, "laser_")
    battery: BatterySettings = group(BatterySettings)
    command_delay: float = number(0.0, 0.0, 2.0, "s", "Time from a command to its arrival at the wheels.")
    command_loss: float = number(0.0, 0.0, 0.95, "", "The part of the commands that do not arrive.")
    docks: tuple[float, ...] = numbers(
        "[y, …]",
        "Where more docks like the first one stand, each with a marker and contacts: in m to its left, along the wall. "
        "Applies at the next start.",
        check_docks,
    )
    obstacles: tuple[Obstacle, ...] = ()
    room: Room | None = None
    dock: DockSettings = group(DockSettings, "contact_")
