"""The JSON shapes of a scene: where a robot and its dock are."""

from typing import Literal

from dock_gateway.web.schemas.common import Schema


class Pose(Schema):
    """A 2D pose, in m and rad; `theta` is counter-clockwise."""

    x: float
    y: float
    theta: float


class Infrared(Schema):
    """Readings of the infrared receivers at the robot's front, in m; null if nothing is detected."""

    left: float | None
    center: float | None
    right: float | None


class Point(Schema):
    """A point in the robot's own frame, `base_link`, in m; x is ahead, y to the left."""

    x: float
    y: float


class Footprint(Schema):
    """The robot's outline. `radius` is that of the circle around it, in m; `points` is null if the robot is round."""

    radius: float
    points: list[Point] | None


class Scene(Schema):
    """Poses of a robot and its dock, all in one frame.

    `dock` is the face of the dock, with its x axis pointing into it. `docked` is the robot's target pose, `staging` the
    pose that it drives to first, and `marker` the last marker pose that the camera saw. `footprint` is the robot's
    outline, null if it is not published.
    """

    frame: Literal["world", "odom"]
    robot: Pose
    dock: Pose | None
    docked: Pose | None
    staging: Pose | None
    marker: Pose | None
    infrared: Infrared | None
    footprint: Footprint | None
