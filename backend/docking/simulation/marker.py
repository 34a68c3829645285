"""The camera that sees the marker on the dock."""

import math
from dataclasses import dataclass
from random import Random

from docking.core.geometry import Pose

CAMERA_X = 0.15
"""The camera is at the robot's front: x in base_link, in m; it looks ahead."""


@dataclass(frozen=True, slots=True)
class MarkerSettings:
    """How well the marker is seen.

    Attributes:
        rate: Pictures a second.
        range: The farthest, in m.
        field_of_view: Of the camera, from edge to edge, in rad.
        view_angle: The most that the marker may be seen from the side, from its normal, in rad.
        noise: Standard deviation of each coordinate, in m.
        angle_noise: Standard deviation of the angle, in rad.
        drop_outs: The part of the pictures in which the marker is not found, 0…1.
    """

    rate: float = 15.0
    range: float = 4.0
    field_of_view: float = math.radians(70.0)
    view_angle: float = math.radians(75.0)
    noise: float = 0.01
    angle_noise: float = math.radians(1.0)
    drop_outs: float = 0.1


class MarkerCamera:
    """Looks for the marker, which is at the world's origin and looks along -x."""

    __slots__ = ("_random", "settings")

    def __init__(self, settings: MarkerSettings, random: Random) -> None:
        """Mount the camera.

        Args:
            settings: How well it sees.
            random: Where noise and drop-outs come from.
        """
        self.settings = settings
        self._random = random

    def can_see(self, robot: Pose) -> bool:
        """Whether the marker is in range, in view and not seen too much from the side, for a robot in world."""
        settings = self.settings
        marker = robot.inverse()
        distance = math.hypot(marker.x - CAMERA_X, marker.y)
        if distance > settings.range:
            return False
        camera_x = robot.x + CAMERA_X * math.cos(robot.theta)
        camera_y = robot.y + CAMERA_X * math.sin(robot.theta)
        return (
            abs(math.atan2(marker.y, marker.x - CAMERA_X)) <= 0.5 * settings.field_of_view
            and abs(math.atan2(camera_y, -camera_x)) <= settings.view_angle
        )

    def look(self, robot: Pose) -> Pose | None:
        """One picture.

        Args:
            robot: base_link in world.

        Returns:
            The marker in base_link, with noise; None where it is not found.
        """
        if not self.can_see(robot):
            return None
        settings, random = self.settings, self._random
        if random.random() < settings.drop_outs:
            return None
        marker = robot.inverse()
        return Pose(
            marker.x + random.gauss(0.0, settings.noise),
            marker.y + random.gauss(0.0, settings.noise),
            marker.theta + random.gauss(0.0, settings.angle_noise),
        )
