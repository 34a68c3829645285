"""The JSON shapes of a robot: battery, docks, scene, simulator and calibration."""

from datetime import datetime
from typing import Literal

from dock_gateway.http.schema import Schema


class BatteryState(Schema):
    """sensor_msgs/BatteryState. `openapi.py` adds the fields from the ROS definition."""


class BatteryStateInput(Schema):
    """As a request has it: every field may be left out. `openapi.py` adds the fields from the ROS definition."""


class Implausible(Schema):
    """A value of a battery state that cannot be right, so that it is not used. An infinity is a text, such as `inf`."""

    field: str
    value: float | str
    expected: str


class Battery(Schema):
    """The battery of a robot: the same in `GET /battery`, in `GET /robots`, in snapshots and in events.

    `state` is the latest message, as it was sent, and null before the first one. `percentage` is its charge (0 to 1)
    as the gateway uses it; null if it is not measured or is `implausible`. A field stays `implausible` until its values
    have been right for 10 seconds. `stale`: nothing has come for `stale_after_s`. A charge below `low_below` (0 to 1)
    is low.
    """

    state: BatteryState | None
    percentage: float | None
    implausible: list[Implausible]
    received_at: datetime | None
    stale: bool
    stale_after_s: float
    low_below: float


class BatteryAnswer(Battery):
    """The answer to `GET /battery`: also the age, which changes all the time.

    `other_topics` have batteries, if that of the robot has sent nothing.
    """

    age_s: float | None
    other_topics: list[str]


class Published(Schema):
    """The message as published."""

    state: BatteryState


class Publisher(Schema):
    """The state of the battery publisher."""

    active: bool
    state: BatteryState | None
    rate_hz: float | None
    published_count: int
    started_at: datetime | None


class SimulatorPlace(Schema):
    """A named pose in the frame `world`, in m and rad."""

    name: str
    x: float
    y: float
    theta: float


class Simulator(Schema):
    """The state of a simulated robot.

    `too_slow`: the machine is too slow for the simulation, whose clock then slows down; `real_time_factor` is the
    measured one. `places` are named poses in the room.
    `contact`: its contacts touch the dock; `docked`: it is also charged there. `battery_publisher` is `self`, or
    `other` while something else publishes the battery state.
    """

    available: bool
    faults: dict[str, bool]
    contact: bool | None
    docked: bool | None
    battery_publisher: str | None
    real_time_factor: float | None
    too_slow: bool | None
    places: list[SimulatorPlace]


class CalibrationService(Schema):
    """Whether a robot's docking server offers the service `calibrate_dock`, and the service's full name."""

    available: bool
    service: str


class CalibratedParameter(Schema):
    """A parameter of the docking server that a calibration has set."""

    name: str
    value: float
    before: float


class Calibration(Schema):
    """What a calibration has measured and set.

    `yaml` is a parameter file with these values. The docking server forgets them when it ends, unless they are written
    into its own parameter file.
    """

    parameters: list[CalibratedParameter]
    yaml: str


class Measured(Schema):
    """The mean, minimum and maximum of a field in each bucket; null if it was not measured."""

    mean: list[float | None]
    min: list[float | None]
    max: list[float | None]


class BatteryHistory(Schema):
    """Columns of equal length, one row per bucket that has messages. `time` is that of the bucket's last message."""

    robot: str
    since: datetime
    until: datetime
    resolution_s: float
    time: list[datetime]
    voltage: Measured
    percentage: Measured
    current: Measured
    temperature: Measured
    power_supply_status: list[int]


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
    outline, null if it is not published. `odom` is where the robot's odometry began; null if that is unknown.
    """

    frame: Literal["world", "odom"]
    robot: Pose
    odom: Pose | None
    dock: Pose | None
    docked: Pose | None
    staging: Pose | None
    marker: Pose | None
    infrared: Infrared | None
    footprint: Footprint | None


class Dock(Schema):
    """A dock of a docking server's database. `tag_id` is that of its AprilTag. What the server does not say is null."""

    dock_id: str
    type: str | None
    frame: str | None
    pose: Pose | None
    tag_id: str | None


class DockList(Schema):
    """The docks of a docking server.

    Attributes:
        node: Full name of the server's node.
        dock_database: The file that its docks are from; null if it has none.
        default: The dock that a request without `dock_id` means; null if the server decides.
        docks: In the order of the server.
    """

    node: str
    dock_database: str | None
    default: str | None
    docks: list[Dock]
