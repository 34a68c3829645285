"""The shapes of the events on a stream; as in `schemas`, nothing is validated or encoded with them at run time."""

from datetime import datetime
from typing import Literal

from pydantic import BaseModel, ConfigDict, Field

from dock_gateway.core.goal import GoalStatus
from dock_gateway.web.schemas.goals import (
    ActionServer,
    Alert,
    Battery,
    BatteryState,
    DockFeedback,
    DockResult,
    Goal,
    GoalError,
    GoalSummary,
    Publisher,
    Robot,
    Schema,
    Simulator,
    StopState,
)


class Vector3(Schema):
    """geometry_msgs/Vector3."""

    x: float | None
    y: float | None
    z: float | None


class Twist(Schema):
    """geometry_msgs/Twist, in m/s and rad/s."""

    linear: Vector3
    angular: Vector3


class Pose(Schema):
    """A pose in the plane, in m and rad, counter-clockwise."""

    x: float
    y: float
    theta: float


class Infrared(Schema):
    """What the infrared receivers at the robot's front measure, in m; null is nothing seen."""

    left: float | None
    center: float | None
    right: float | None


class Scene(Schema):
    """Where a robot and its dock are, all in one frame.

    `dock` is the face of the dock, its x axis pointing into it; `docked` where the robot is to stand; `staging` where
    it drives to first; `marker` what the camera saw last.
    """

    frame: Literal["world", "odom"]
    robot: Pose
    dock: Pose | None
    docked: Pose | None
    staging: Pose | None
    marker: Pose | None
    infrared: Infrared | None


class SnapshotEvent(Schema):
    """The first message of a stream; `robots` and `alerts` are there where `include=robots` asks for them."""

    model_config = ConfigDict(json_schema_serialization_defaults_required=False)

    type: Literal["snapshot"]
    time: datetime
    goals: list[Goal]
    battery: Battery
    battery_publisher: Publisher
    stop: StopState
    action_server: ActionServer
    undock_server: ActionServer
    robots: list[Robot] = Field(default_factory=list)
    alerts: list[Alert] = Field(default_factory=list)


class StatusEvent(GoalSummary):
    """A goal's state changed."""

    type: Literal["status"]
    id: str
    time: datetime


class FeedbackEvent(Schema):
    """A goal's feedback."""

    type: Literal["feedback"]
    id: str
    time: datetime
    goal_id: str
    action_name: str
    feedback: DockFeedback


class ResultEvent(Schema):
    """A goal ended."""

    type: Literal["result"]
    id: str
    time: datetime
    goal_id: str
    action_name: str
    status: GoalStatus
    result: DockResult | None
    error: GoalError | None


class BatteryEvent(Schema):
    """A message of the battery topic."""

    type: Literal["battery"]
    id: str
    time: datetime
    robot: str
    battery: BatteryState


class CmdVelEvent(Schema):
    """A message of the velocity topic."""

    type: Literal["cmd_vel"]
    id: str
    time: datetime
    robot: str
    cmd_vel: Twist


class PublisherEvent(Schema):
    """The battery publisher changed, or went on (once a second)."""

    type: Literal["battery_publisher"]
    time: datetime
    robot: str
    battery_publisher: Publisher


class ActionServerEvent(Schema):
    """The action server came, went, fell silent or answers again."""

    type: Literal["action_server"]
    time: datetime
    action_server: ActionServer


class StopEvent(Schema):
    """A stop was latched or released."""

    type: Literal["stop"]
    time: datetime
    robot: str
    stop: StopState


class SimulatorEvent(Schema):
    """A simulated robot was told something by hand, touched its dock or left it; or the simulator came or went."""

    type: Literal["simulator"]
    time: datetime
    robot: str
    simulator: Simulator


class RobotsEvent(Schema):
    """Robots changed: those that did, as they are now, at most twice a second; and the names of those that left."""

    type: Literal["robots"]
    time: datetime
    robots: list[Robot]
    gone: list[str]


class AlertsEvent(Schema):
    """The alerts changed: all of them, as they are now."""

    type: Literal["alerts"]
    time: datetime
    alerts: list[Alert]


class SceneEvent(Schema):
    """Where a robot and its dock are, up to 20 times a second."""

    type: Literal["scene"]
    time: datetime
    robot: str
    scene: Scene


class HeartbeatEvent(Schema):
    """The stream lives."""

    type: Literal["heartbeat"]
    time: datetime


class DroppedEvent(Schema):
    """So many feedback events were dropped because this reader is slow."""

    type: Literal["dropped"]
    time: datetime
    count: int


class FeedbackDroppedEvent(Schema):
    """Feedback of a goal that the gateway did not read: too large, or too fast to follow. Nobody got it."""

    type: Literal["feedback_dropped"]
    time: datetime
    goal_id: str
    action_name: str
    reason: Literal["feedback_too_large", "feedback_too_fast"]
    count: int


class ResumedEvent(Schema):
    """The first message of a stream that goes on after an event: so many follow that were missed."""

    type: Literal["resumed"]
    time: datetime
    after: str
    count: int


class GapEvent(Schema):
    """What followed an event is not to be had any more; a snapshot comes instead."""

    type: Literal["gap"]
    time: datetime
    after: str


class ClosingEvent(Schema):
    """The last message of a stream."""

    type: Literal["closing"]
    time: datetime
    reason: str


EVENTS: tuple[type[BaseModel], ...] = (
    SnapshotEvent,
    StatusEvent,
    FeedbackEvent,
    ResultEvent,
    BatteryEvent,
    CmdVelEvent,
    PublisherEvent,
    ActionServerEvent,
    StopEvent,
    SimulatorEvent,
    RobotsEvent,
    AlertsEvent,
    SceneEvent,
    HeartbeatEvent,
    DroppedEvent,
    FeedbackDroppedEvent,
    ResumedEvent,
    GapEvent,
    ClosingEvent,
)
