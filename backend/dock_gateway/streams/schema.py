"""Schemas of stream events, for the OpenAPI document: nothing is validated or encoded with them at run time."""

from datetime import datetime
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from dock_gateway.core.goal import GoalStatus
from dock_gateway.fleet.schema import Alert, Robot
from dock_gateway.goals.action_schema import ActionServer
from dock_gateway.goals.approval_schema import Approval
from dock_gateway.goals.schema import DockFeedbackMessage, DockResultMessage, GoalError, GoalSummary, LiveGoal
from dock_gateway.http.schema import Schema
from dock_gateway.robots.schema import Battery, Publisher, Scene, Simulator
from dock_gateway.stop.schema import StopState

# The default of a field that is absent where it was not asked for; the document shows none.
UNASKED: Any = Field(default_factory=dict)


class Vector3(Schema):
    """geometry_msgs/Vector3."""

    x: float | None
    y: float | None
    z: float | None


class Twist(Schema):
    """geometry_msgs/Twist, in m/s and rad/s."""

    linear: Vector3
    angular: Vector3


class SystemEvent(Schema):
    """An event of the group `system`: what a robot's page shows beside its messages."""


class FleetEvent(Schema):
    """An event of the group `fleet`: what an overview of all robots shows."""


class DockingServers(Schema):
    """The servers of a robot's docking and undocking actions."""

    dock: ActionServer
    undock: ActionServer


class SnapshotEvent(Schema):
    """The first message of a stream. `id` is the last event before it, of whatever kind: resume after it.

    Besides goals it has only what `include` asks for: each such field is the state that events of the same type change.
    `simulator` is null where there never was one.
    """

    model_config = ConfigDict(json_schema_serialization_defaults_required=False)

    type: Literal["snapshot"]
    id: str
    time: datetime
    goals: list[LiveGoal]
    battery: Battery = UNASKED
    battery_publisher: Publisher = UNASKED
    stop: StopState = UNASKED
    docking: DockingServers = UNASKED
    simulator: Simulator | None = UNASKED
    robots: list[Robot] = UNASKED
    alerts: list[Alert] = UNASKED
    approvals: list[Approval] = UNASKED


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
    feedback: DockFeedbackMessage


class ResultEvent(Schema):
    """A goal ended."""

    type: Literal["result"]
    id: str
    time: datetime
    goal_id: str
    action_name: str
    status: GoalStatus
    result: DockResultMessage | None
    error: GoalError | None


class BatteryEvent(Schema):
    """A message of the battery topic has come."""

    type: Literal["battery"]
    id: str
    time: datetime
    robot: str
    battery: Battery


class CmdVelEvent(Schema):
    """A message of the velocity topic."""

    type: Literal["cmd_vel"]
    id: str
    time: datetime
    robot: str
    cmd_vel: Twist


class PublisherEvent(SystemEvent):
    """The state of the battery publisher: sent when it changes, and once a second while it publishes."""

    type: Literal["battery_publisher"]
    time: datetime
    robot: str
    battery_publisher: Publisher


class ActionServerEvent(SystemEvent):
    """An action server appeared, disappeared, stopped answering or answers again."""

    type: Literal["action_server"]
    time: datetime
    action_server: ActionServer


class DockingEvent(SystemEvent):
    """Another action is behind `/dock` or `/undock` of a robot."""

    type: Literal["docking"]
    time: datetime
    robot: str
    docking: DockingServers


class StopEvent(SystemEvent):
    """A stop was latched or released. `id` is null in the present state, which a reader who resumes gets last."""

    type: Literal["stop"]
    id: str | None
    time: datetime
    robot: str
    stop: StopState


class SimulatorEvent(SystemEvent):
    """A simulated robot was changed by hand, touched or left its dock, or its simulator appeared or disappeared."""

    type: Literal["simulator"]
    time: datetime
    robot: str
    simulator: Simulator


class RobotsEvent(FleetEvent):
    """The current state of robots that changed; `gone` names those that left. At most twice a second."""

    type: Literal["robots"]
    time: datetime
    robots: list[Robot]
    gone: list[str]


class AlertsEvent(FleetEvent):
    """The alerts changed. Contains all active alerts."""

    type: Literal["alerts"]
    time: datetime
    alerts: list[Alert]


class ApprovalsEvent(FleetEvent):
    """The goals of agents that wait for approval changed. Contains all that wait."""

    type: Literal["approvals"]
    time: datetime
    approvals: list[Approval]


class SceneEvent(Schema):
    """The poses of a robot and its dock, up to 20 times a second."""

    type: Literal["scene"]
    time: datetime
    robot: str
    scene: Scene


class ScenesEvent(Schema):
    """The scenes of all robots that have one, by robot, up to 5 times a second. `marker` and `infrared` are null."""

    type: Literal["scenes"]
    time: datetime
    scenes: dict[str, Scene]


class HeartbeatEvent(Schema):
    """The stream is alive. `id` is the last event before it, of whatever kind: resume after it."""

    type: Literal["heartbeat"]
    id: str
    time: datetime


class DroppedEvent(Schema):
    """`count` feedback events were dropped because this reader is too slow."""

    type: Literal["dropped"]
    time: datetime
    count: int


class FeedbackDroppedEvent(Schema):
    """Feedback of a goal that the gateway did not read because it is too large or too fast. No reader received it."""

    type: Literal["feedback_dropped"]
    time: datetime
    goal_id: str
    action_name: str
    reason: Literal["feedback_too_large", "feedback_too_fast"]
    count: int


class ResumedEvent(Schema):
    """The first message of a resumed stream. The `count` missed events follow."""

    type: Literal["resumed"]
    time: datetime
    after: str
    count: int


class GapEvent(Schema):
    """Some events after `after` are no longer available. The remaining ones follow, then a snapshot."""

    type: Literal["gap"]
    time: datetime
    after: str
    count: int


class ClosingEvent(Schema):
    """The last message of a stream."""

    type: Literal["closing"]
    time: datetime
    reason: str


# What a stream of one goal sends.
GOAL_EVENTS: tuple[type[BaseModel], ...] = (
    SnapshotEvent,
    StatusEvent,
    FeedbackEvent,
    ResultEvent,
    HeartbeatEvent,
    DroppedEvent,
    FeedbackDroppedEvent,
    ResumedEvent,
    GapEvent,
    ClosingEvent,
)
EVENTS: tuple[type[BaseModel], ...] = (
    *GOAL_EVENTS,
    BatteryEvent,
    CmdVelEvent,
    PublisherEvent,
    ActionServerEvent,
    DockingEvent,
    StopEvent,
    SimulatorEvent,
    RobotsEvent,
    AlertsEvent,
    ApprovalsEvent,
    SceneEvent,
    ScenesEvent,
)
