"""The JSON shapes of robots: battery, stop, alerts, calibration, simulator."""

from datetime import datetime
from typing import Literal

from pydantic import ConfigDict, JsonValue

from dock_gateway.fleet.alert_rules import AlertKind
from dock_gateway.web.schemas.actions import ActionServer
from dock_gateway.web.schemas.common import Problem, Schema
from dock_gateway.web.schemas.goals import BatteryState, GoalState


class StopFailure(Schema):
    """A part of a stop that failed: canceling the goals of an action, or publishing zero velocity to a robot."""

    action_name: str | None
    robot: str | None
    code: str
    detail: str


class StopState(Schema):
    """Whether a stop is latched for a robot, since when and by whom.

    `robots` lists the robots at or below it that a stop holds. `persisted` is false if the gateway could not store its
    latest stop or release, so that a restart would lose it.
    """

    latched: bool
    since: datetime | None
    by: str | None
    robots: list[str]
    persisted: bool


class StopReport(Schema):
    """The result of a stop.

    `unconfirmed` lists actions that were asked to cancel their goals and have not answered yet. `warning` says what in
    the request could not be read and was ignored, or that the stop is not stored yet.
    """

    canceling: list[str]
    failed: list[StopFailure]
    unconfirmed: list[str]
    stop: StopState
    warning: "Problem | None"


class StopProblem(Problem):
    """Zero velocity could not be published to any robot. The other members say what was done nevertheless."""

    canceling: list[str] | None = None
    failed: list[StopFailure] | None = None
    unconfirmed: list[str] | None = None
    stop: StopState | None = None


class Implausible(Schema):
    """A value of a battery state that cannot be right, so that it is not used. An infinity is a text, such as `inf`."""

    field: str
    value: float | str
    expected: str


class Battery(Schema):
    """The latest battery state and its age. A charge below `low_below` (0 to 1) is low.

    `state` is as it was sent. `percentage` is its charge (0 to 1) as the gateway uses it; null if it is not measured
    or is `implausible`. What is `implausible` stays so until it has been right for 10 seconds.
    """

    state: BatteryState | None
    percentage: float | None
    implausible: list[Implausible]
    age_s: float | None
    stale: bool
    stale_after_s: float
    low_below: float
    received_at: datetime | None


class BatteryAnswer(Battery):
    """The answer to `GET /battery`. `other_topics` have batteries, if that of the robot has sent nothing."""

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


class RobotBattery(Schema):
    """The latest battery state, with the time of reception instead of its age; otherwise as `GET /battery`."""

    state: BatteryState | None
    percentage: float | None
    implausible: list[Implausible]
    received_at: datetime | None
    stale: bool
    stale_after_s: float
    low_below: float


class RobotPublisher(Schema):
    """Whether the gateway publishes a battery state for the robot, and how often."""

    active: bool
    rate_hz: float | None


class RobotJoin(Schema):
    """How a robot gets a docking server that is in another namespace: what to set, as lines and in words."""

    detail: str
    settings: list[str]


class Robot(Schema):
    """Summary of a robot.

    `name` is its namespace; `display_name` and `groups` are the label that `PUT /robots/label` sets.
    `docked` is null if unknown, and so is `charging`: whether its battery is charged or full. `dock` and `undock` are
    null if the robot has no such action. `goals` are those running on its actions; `last_goal` is the last docking or
    undocking goal that ended. `join` is null unless the robot has a battery and no docking server, and one
    without a battery is in another namespace.
    """

    name: str
    display_name: str | None
    groups: list[str]
    default: bool
    docked: bool | None
    charging: bool | None
    simulated: bool
    battery: RobotBattery
    battery_topic: str
    battery_publisher: RobotPublisher
    stop: StopState
    dock: ActionServer | None
    undock: ActionServer | None
    join: RobotJoin | None
    goals: list[GoalState]
    last_goal: GoalState | None


class RobotList(Schema):
    """The robots, by name."""

    robots: list[Robot]


LABEL_EXAMPLE: JsonValue = {"robot": "/robot1", "display_name": "Left forklift", "groups": ["hall 1", "forklifts"]}


class Label(Schema):
    """The display name of a robot, null if it has none, and the groups that it is in."""

    model_config = ConfigDict(json_schema_extra={"examples": [LABEL_EXAMPLE]})

    robot: str
    display_name: str | None
    groups: list[str]


class Acknowledgement(Schema):
    """Who acknowledged an alert, and when."""

    by: str
    at: datetime


class Alert(Schema):
    """A condition that an operator has to know about.

    `robot` is the robot, the namespace of an action that belongs to no robot, or null for the gateway itself. `detail`
    says what to do.
    """

    id: str
    kind: AlertKind
    robot: str | None
    severity: Literal["critical", "warning"]
    since: datetime
    title: str
    detail: str
    goal_id: str | None
    acknowledged: Acknowledgement | None


class AlertList(Schema):
    """The active alerts: critical ones first, then oldest first."""

    alerts: list[Alert]


class Simulator(Schema):
    """The state of a simulated robot.

    `contact`: its contacts touch the dock; `docked`: it is also charged there. `battery_publisher` is `self`, or
    `other` while something else publishes the battery state.
    """

    available: bool
    faults: dict[str, bool]
    contact: bool | None
    docked: bool | None
    battery_publisher: str | None
    real_time_factor: float | None


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
