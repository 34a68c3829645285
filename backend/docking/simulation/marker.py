"""The camera that sees the marker on the dock."""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from random import Random

from docking.core.geometry import Pose, normalize_angle
from docking.core.parameter import number, switch
from docking.simulation.box import Box
from docking.simulation.obstacle import Obstacle

CAMERA_X = 0.15
"""Distance of the camera from base_link, in m; it looks away from it."""
EXACT = Pose()
"""The error of a camera that is mounted where it is taken to be."""
FLAT = math.radians(30.0)
"""From its normal: a flat marker that is seen from less than this, in rad, can be taken for its mirror image."""
MIRRORED_FOR = 0.5
"""For how long it is then taken for the same one of the two, in s: images that follow each other look alike."""
HALF_WIDTH = 0.04
"""Half the width of the marker, in m, where the edge of the image cuts it off."""
GHOST = Pose(0.3, 0.8, -0.3)
"""Where a reflection of the marker seems to be, in world."""
OUTLIER_DISTANCE = 0.5
"""How far, in m, an outlier is from the marker at most, along each axis."""
OUTLIER_ANGLE = 1.0
"""How far it is turned against the marker at most, in rad."""


@dataclass(frozen=True, slots=True)
class MarkerSettings:
    """Settings of how well the marker is seen.

    Attributes:
        view_angle: The most that the marker may be seen from the side, from its normal, in rad.
        mount_error: Where the camera is in truth, as seen from where the robot's software takes it to be.
    """

    rate: float = number(15.0, 0.1, 50.0, "Hz", "Images per second.")
    range: float = number(4.0, 0.0, 50.0, "m", "Maximum range at which the camera detects the marker.")
    range_min: float = number(
        0.0,
        0.0,
        5.0,
        "m",
        "Minimum range: nearer, the camera does not detect the marker, such as one that is too large.",
    )
    field_of_view: float = number(math.radians(70.0), 0.0, 6.28, "rad", "Field of view of the camera, edge to edge.")
    camera_yaw: float = number(
        0.0,
        -3.1416,
        3.1416,
        "rad",
        "Direction in which the camera looks, from the robot's edge; 0: ahead, 3.1416: behind.",
    )
    camera_error_x: float = number(
        0.0, -0.5, 0.5, "m", "How much farther ahead the camera is mounted than the robot's software takes it to be."
    )
    camera_error_y: float = number(
        0.0, -0.5, 0.5, "m", "How far to the left of where the robot's software takes it to be the camera is mounted."
    )
    view_angle: float = math.radians(75.0)
    noise: float = number(0.01, 0.0, 1.0, "m", "Standard deviation of the marker's position, for each coordinate.")
    angle_noise: float = number(math.radians(1.0), 0.0, 1.0, "rad", "Standard deviation of the marker's heading.")
    drop_outs: float = number(0.1, 0.0, 1.0, "", "Fraction of the camera images in which the marker is missed.")
    noise_per_metre: float = number(
        0.0, 0.0, 1.0, "m", "What marker_noise grows by for each m between the camera and the marker."
    )
    noise_per_square_metre: float = number(
        0.0, 0.0, 1.0, "m", "What marker_noise grows by at 1 m: it grows with the square of the distance."
    )
    noise_per_radian: float = number(
        0.0, 0.0, 1.0, "rad", "What marker_angle_noise grows by for each rad that the marker is seen from the side."
    )
    mirrored: float = number(
        0.0,
        0.0,
        1.0,
        "",
        "Fraction of the detections of a marker that is seen less than 30 degrees from the side whose heading is "
        "mirrored at the line of sight, as often with flat markers.",
    )
    cut_off_bias: float = number(
        0.0,
        0.0,
        1.0,
        "",
        "Where a marker seems to be that the edge of the image cuts off: 0: where it is; 1: in the middle of what is "
        "visible of it.",
    )
    outliers: float = number(0.0, 0.0, 1.0, "", "Fraction of the detections that are somewhere else, and turned.")
    ghosts: float = number(
        0.0, 0.0, 1.0, "", "Fraction of the detections that are of a reflection, always at the same place."
    )
    hidden_every: float = number(
        0.0, 0.0, 3600.0, "s", "Time between the moments at which something begins to hide the marker; 0: never."
    )
    hidden_for: float = number(0.0, 0.0, 3600.0, "s", "Time for which it does.")
    angle_bias: float = number(
        0.0, -1.57, 1.57, "rad", "How far each detection is turned to the left, as with a marker that is not flat."
    )
    mount_error: Pose = EXACT
    second_y: float = number(
        0.0,
        -5.0,
        5.0,
        "m",
        "Where a second marker is, to the left of the first, on the same topic; 0: there is none.",
    )
    delay: float = number(0.0, 0.0, 2.0, "s", "Time from an image to the arrival of its detection.")
    honest_stamps: bool = switch(
        True, "Whether the stamp of a detection is the moment of the image; else it is that of its arrival."
    )
    stamp_offset: float = number(
        0.0,
        -86400.0,
        86400.0,
        "s",
        "How far the clock of the detections' stamps is ahead of that of the other sensors.",
    )


class MarkerCamera:
    """Looks for the marker, which is at the world's origin and looks along -x."""

    __slots__ = ("_mirrored", "_period", "_random", "_wrong", "settings")

    def __init__(self, settings: MarkerSettings, random: Random, wrong: Random) -> None:
        """Mount the camera.

        Args:
            settings: How well it sees.
            random: Where noise and drop-outs come from.
            wrong: Where outliers and reflections come from.
        """
        self.settings = settings
        self._random = random
        self._wrong = wrong
        self._period, self._mirrored = -1, False

    def can_see(self, robot: Pose, obstacles: Iterable[Obstacle | Box] = ()) -> bool:
        """Whether the marker is in range, in view, not hidden and not seen too much from the side.

        Args:
            robot: base_link in world.
            obstacles: Obstacles that may be in between.
        """
        settings, robot = self.settings, self._turned(robot)
        marker = robot.inverse()
        distance = math.hypot(marker.x - CAMERA_X, marker.y)
        if not settings.range_min <= distance <= settings.range:
            return False
        camera_x, camera_y = _camera(robot)
        return (
            abs(math.atan2(marker.y, marker.x - CAMERA_X)) <= 0.5 * settings.field_of_view
            and abs(math.atan2(camera_y, -camera_x)) <= settings.view_angle
            and not any(obstacle.hides(camera_x, camera_y) for obstacle in obstacles)
        )

    def detect(
        self, robot: Pose, now: float = 0.0, obstacles: Iterable[Obstacle | Box] = (), outliers: float = 0.0
    ) -> Pose | None:
        """One picture.

        Args:
            robot: base_link in world.
            now: Seconds since the start.
            obstacles: Obstacles that may be in between.
            outliers: The part of the detections that are somewhere else, beyond that of the settings.

        Returns:
            The marker in base_link, with noise; None where it is not found.
        """
        settings, random = self.settings, self._random
        if not self.can_see(robot, obstacles) or self._hidden(now):
            return None
        if random.random() < settings.drop_outs:
            return None
        marker = robot.inverse()
        noise, angle_noise = settings.noise, settings.angle_noise
        camera_x, camera_y = _camera(self._turned(robot))
        distance, side = math.hypot(camera_x, camera_y), math.atan2(camera_y, -camera_x)
        noise += settings.noise_per_metre * distance + settings.noise_per_square_metre * distance**2
        angle_noise += settings.noise_per_radian * abs(side)
        marker = self._cut_off(marker)
        seen = Pose(
            marker.x + random.gauss(0.0, noise),
            marker.y + random.gauss(0.0, noise),
            normalize_angle(marker.theta + settings.angle_bias + random.gauss(0.0, angle_noise)),
        )
        if self._is_mirrored(now) and abs(side) < FLAT:
            # Seen from the side by this angle, it seems to be seen from the other side.
            seen = Pose(seen.x, seen.y, normalize_angle(seen.theta - 2.0 * side))
        if settings.camera_error_x != 0.0 or settings.camera_error_y != 0.0:
            seen = Pose(-settings.camera_error_x, -settings.camera_error_y).compose(seen)
        if settings.mount_error != EXACT:
            seen = settings.mount_error.inverse().compose(seen)
        return self._mistaken(robot, seen, max(outliers, settings.outliers))

    def _is_mirrored(self, now: float) -> bool:
        """Whether the marker is taken for its mirror image now."""
        period = math.floor(now / MIRRORED_FOR)
        if self.settings.mirrored > 0.0 and period != self._period:
            self._period, self._mirrored = period, self._wrong.random() < self.settings.mirrored
        return self._mirrored

    def _cut_off(self, marker: Pose) -> Pose:
        """Return where the marker seems to be if the edge of the image cuts it off, as seen from the robot."""
        settings = self.settings
        if settings.cut_off_bias == 0.0:
            return marker
        camera = camera_mount(settings.camera_yaw)
        seen = marker.relative_to(camera)
        edge = seen.x * math.tan(min(0.5 * settings.field_of_view, 1.5))
        left, right = min(seen.y + HALF_WIDTH, edge), max(seen.y - HALF_WIDTH, -edge)
        shift = settings.cut_off_bias * (0.5 * (left + right) - seen.y)
        return camera.compose(Pose(seen.x, seen.y + shift, seen.theta))

    def _turned(self, robot: Pose) -> Pose:
        """The robot as if the camera looked ahead."""
        return robot.compose(Pose(theta=self.settings.camera_yaw))

    def _hidden(self, now: float) -> bool:
        every = self.settings.hidden_every
        return every > 0.0 and now % every < self.settings.hidden_for

    def _mistaken(self, robot: Pose, seen: Pose, outliers: float) -> Pose:
        wrong, ghosts = self._wrong, self.settings.ghosts
        if ghosts > 0.0 and wrong.random() < ghosts:
            return GHOST.relative_to(robot)
        if outliers > 0.0 and wrong.random() < outliers:
            return Pose(
                seen.x + wrong.uniform(-OUTLIER_DISTANCE, OUTLIER_DISTANCE),
                seen.y + wrong.uniform(-OUTLIER_DISTANCE, OUTLIER_DISTANCE),
                normalize_angle(seen.theta + wrong.uniform(-OUTLIER_ANGLE, OUTLIER_ANGLE)),
            )
        return seen


def camera_mount(yaw: float) -> Pose:
    """Return the pose in base_link where the camera is taken to be.

    Args:
        yaw: Where it looks, in rad; it is at the robot's edge there.
    """
    return Pose(CAMERA_X * math.cos(yaw), CAMERA_X * math.sin(yaw), yaw)


def _camera(robot: Pose) -> tuple[float, float]:
    """Return where the camera is in world."""
    return robot.x + CAMERA_X * math.cos(robot.theta), robot.y + CAMERA_X * math.sin(robot.theta)
