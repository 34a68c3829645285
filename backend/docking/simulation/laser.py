"""The laser scanner: sees the dock, obstacles and the room all around."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from docking.core.geometry import Pose
from docking.core.parameter import number
from docking.simulation.box import Box
from docking.simulation.dock import Dock
from docking.simulation.obstacle import Obstacle
from docking.simulation.room import Room

Distances = npt.NDArray[np.float64]

ANGLE_MIN = -math.pi
"""Of the first ray, in rad to the left of the scanner's x axis."""


@dataclass(frozen=True, slots=True)
class LaserSettings:
    """Properties of the scanner and its mount.

    Attributes:
        rays: Of a scan, all around.
        minimum: Minimum range, in m.
    """

    rate: float = number(10.0, 0.1, 50.0, "Hz", "Scans per second; none are made while nothing subscribes to them.")
    range: float = number(8.0, 0.1, 50.0, "m", "Maximum range of the laser scanner.")
    noise: float = number(0.005, 0.0, 1.0, "m", "Standard deviation of a measured distance.")
    x: float = number(0.0, -1.0, 1.0, "m", "Position of the laser scanner: x in base_link.")
    y: float = number(0.0, -1.0, 1.0, "m", "The same, y.")
    yaw: float = number(0.0, -3.15, 3.15, "rad", "Direction of its x axis.")
    rays: int = 360
    minimum: float = 0.05

    @property
    def mount(self) -> Pose:
        """The scanner in base_link."""
        return Pose(self.x, self.y, self.yaw)

    @property
    def angle_increment(self) -> float:
        """From one ray to the next, in rad."""
        return math.tau / self.rays


class LaserScanner:
    """Measures distances."""

    __slots__ = ("_angles", "_noise", "settings")

    def __init__(self, settings: LaserSettings, seed: int) -> None:
        """Mount the scanner.

        Args:
            settings: Its properties.
            seed: Of its noise.
        """
        self.settings = settings
        self._angles = ANGLE_MIN + settings.angle_increment * np.arange(settings.rays)
        self._noise = np.random.default_rng(seed)

    def scan(self, robot: Pose, dock: Dock, obstacles: Sequence[Obstacle], room: Room | None = None) -> Distances:
        """One scan: a distance for each ray, in m; infinite where nothing is seen (REP-117).

        Args:
            robot: base_link in world.
            dock: The dock.
            obstacles: Other obstacles.
            room: Where all this is.
        """
        settings, scanner = self.settings, robot.compose(self.settings.mount)
        angles = self._angles + scanner.theta
        cos, sin = np.cos(angles), np.sin(angles)
        if room is None:
            distances = _to_boxes(scanner, cos, sin, dock.boxes)
        else:
            seen_within = _to_boxes(scanner, cos, sin, (*dock.boxes, *room.furniture))
            distances = np.minimum(seen_within, _to_walls(scanner, cos, sin, room.floor))
        for obstacle in obstacles:
            distances = np.minimum(distances, _to_circle(scanner, cos, sin, obstacle))
        distances = distances + self._noise.normal(0.0, settings.noise, len(distances))
        seen = (distances >= settings.minimum) & (distances <= settings.range)
        return np.where(seen, distances, math.inf)


def _to_circle(scanner: Pose, cos: Distances, sin: Distances, circle: Obstacle) -> Distances:
    x, y = circle.x - scanner.x, circle.y - scanner.y
    along = x * cos + y * sin
    within = circle.radius**2 - (x * sin - y * cos) ** 2
    near = along - np.sqrt(np.maximum(within, 0.0))
    return np.where((within > 0.0) & (near > 0.0), near, math.inf)


def _to_boxes(scanner: Pose, cos: Distances, sin: Distances, boxes: Sequence[Box]) -> Distances:
    """To the nearest box."""
    enters, leaves = _cross(scanner, cos, sin, boxes)
    return np.asarray(np.where((enters <= leaves) & (enters > 0.0), enters, math.inf).min(axis=0))


def _to_walls(scanner: Pose, cos: Distances, sin: Distances, floor: Box) -> Distances:
    return np.asarray(_cross(scanner, cos, sin, (floor,))[1][0])


def _cross(scanner: Pose, cos: Distances, sin: Distances, boxes: Sequence[Box]) -> tuple[Distances, Distances]:
    """Return where each ray enters and leaves each box: it is in a box where it is between both pairs of sides."""
    x_min, y_min, x_max, y_max = np.array([(box.x_min, box.y_min, box.x_max, box.y_max) for box in boxes]).T[:, :, None]
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        by_x = (x_min - scanner.x) / cos, (x_max - scanner.x) / cos
        by_y = (y_min - scanner.y) / sin, (y_max - scanner.y) / sin
    enters = np.maximum(np.minimum(*by_x), np.minimum(*by_y))
    leaves = np.minimum(np.maximum(*by_x), np.maximum(*by_y))
    return enters, leaves
