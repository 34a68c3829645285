"""The JSON shapes of maps, scans and paths."""

from datetime import datetime
from typing import Literal

from pydantic import Field

from dock_gateway.http.schema import Schema
from dock_gateway.robots.schema import Pose


class Grid(Schema):
    """A map without its cells.

    Attributes:
        revision: The same for the same map; that of the image is in its `ETag`.
        stamped_at: When it was made, as its message says; null if it does not.
        frame: The frame of the origin.
        resolution: The length of a cell's side, in metres.
        width: Number of columns.
        height: Number of rows.
        origin: The lower left corner.
    """

    revision: str
    stamped_at: datetime | None
    frame: str
    resolution: float
    width: int
    height: int
    origin: Pose


class RobotMap(Schema):
    """The map of a robot.

    Attributes:
        topic: The topic that it is read from; null if none is published.
        map: The newest good map; null if there is none.
        odom: Where the robot's odometry begins in the map's frame, by `tf`; null if the frames are not related.
        hint: What is missing, or why the newest message is not used, in a sentence; null if all is well.
    """

    topic: str | None
    map: Grid | None
    odom: Pose | None
    hint: str | None


class Points(Schema):
    """What a laser sees, or a path: at most 360 points in metres.

    Attributes:
        frame: `map`, or the robot's `odom` or `base_link`, whatever `tf` calls them; null without points.
        points: Each is x and y.
        hint: Why there are none, in a sentence; null if all is well.
    """

    frame: Literal["map", "odom", "base_link"] | None
    points: list[list[float]] = Field(max_length=360)
    hint: str | None


class MapEvent(Schema):
    """The robot's map changed: not its cells, which `GET /map.png` has. At most 5 times a second."""

    type: Literal["map"]
    time: datetime
    robot: str
    map: RobotMap


class MapsEvent(Schema):
    """The maps of all robots that have one, by robot."""

    type: Literal["maps"]
    time: datetime
    maps: dict[str, RobotMap]


class ScanEvent(Schema):
    """What the robot's laser sees, up to 5 times a second."""

    type: Literal["scan"]
    time: datetime
    robot: str
    scan: Points


class PathEvent(Schema):
    """The path that the robot is to drive."""

    type: Literal["path"]
    time: datetime
    robot: str
    path: Points


# What streams can ask for.
EVENTS = (MapEvent, MapsEvent, ScanEvent, PathEvent)
