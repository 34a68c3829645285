"""Schemas of requests and responses, for the OpenAPI document and the types generated from it.

Nothing is validated or encoded with them at run time: the ROS definitions decide what messages contain.
"""

from datetime import datetime
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict

from dock_gateway.core.goal import GoalStatus
from dock_gateway.fleet.alert_rules import AlertKind


class Schema(BaseModel):
    """Base of the schemas. Every field is always present."""

    model_config = ConfigDict(json_schema_serialization_defaults_required=True, extra="forbid")


class BatteryState(Schema):
    """sensor_msgs/BatteryState. `web/openapi.py` adds the fields from the ROS definition."""


class DockGoal(Schema):
    """Goal of ConnectToChargingDock and DisconnectFromChargingDock."""

    desired_battery_state: BatteryState


class DockFeedback(Schema):
    """Feedback of ConnectToChargingDock and DisconnectFromChargingDock."""

    current_battery_state: BatteryState


class DockResult(Schema):
    """Result of ConnectToChargingDock and DisconnectFromChargingDock."""

    final_battery_state: BatteryState


class GoalError(Schema):
    """Why a goal did not succeed."""

    code: str
    detail: str


class GoalState(Schema):
    """The state of any goal, without its messages."""

    goal_id: str
    action_name: str
    action_type: str
    status: GoalStatus
    stalled: bool
    origin: Literal["gateway", "external"]
    stage: str | None
    retries: int | None
    error: GoalError | None
    created_at: datetime
    updated_at: datetime
    finished_at: datetime | None
    feedback_count: int
    last_event_id: str | None


class GoalSummary(GoalState):
    """A goal of docking or undocking without its feedback and result."""

    goal: DockGoal | None


class ActionGoal(GoalState):
    """A goal on any action; goal, feedback and result hold the fields of the action's messages."""

    goal: dict[str, Any] | None
    feedback: dict[str, Any] | None
    result: dict[str, Any] | None


class ActionGoalPage(Schema):
    """Goals on any action, newest first."""

    goals: list[ActionGoal]
    next_cursor: str | None


class Goal(GoalSummary):
    """A goal of docking or undocking."""

    feedback: DockFeedback | None
    result: DockResult | None


class GoalPage(Schema):
    """Goals, newest first."""

    goals: list[Goal]
    next_cursor: str | None


class StopFailure(Schema):
    """A part of a stop that failed: canceling the goals of an action, or publishing zero velocity to a robot."""

    action_name: str | None
    robot: str | None
    code: str
    detail: str


class StopState(Schema):
    """Whether a stop is latched for a robot, since when and by whom.

    `robots` lists the robots at or below it that a stop holds. `persisted` is false if the gateway could not store its
    latest stop or release, so that a restart would forget it.
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


class Battery(Schema):
    """The latest battery state and its age."""

    state: BatteryState | None
    age_s: float | None
    stale: bool
    stale_after_s: float
    received_at: datetime | None


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


class ActionServer(Schema):
    """Whether an action server is on the graph and answers. `duplicate` is true if there is more than one."""

    action_name: str
    available: bool
    answering: bool
    duplicate: bool


class RobotBattery(Schema):
    """The latest battery state, with the time of reception instead of its age."""

    state: BatteryState | None
    received_at: datetime | None
    stale: bool
    stale_after_s: float


class RobotPublisher(Schema):
    """Whether the gateway publishes a battery state for the robot, and how often."""

    active: bool
    rate_hz: float | None


class Robot(Schema):
    """Summary of a robot.

    `docked` is null if unknown; `dock` and `undock` are null if the robot has no such action. `goals` are those running
    on its actions; `last_goal` is the last docking or undocking goal that ended.
    """

    name: str
    default: bool
    docked: bool | None
    simulated: bool
    battery: RobotBattery
    battery_topic: str
    battery_publisher: RobotPublisher
    stop: StopState
    dock: ActionServer | None
    undock: ActionServer | None
    goals: list[GoalState]
    last_goal: GoalState | None


class RobotList(Schema):
    """The robots, by name."""

    robots: list[Robot]


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


class ActionInfo(ActionServer):
    """An action on the graph; `hint` says what to install if its package is missing."""

    action_type: str
    installed: bool
    hint: str | None
    running_goals: int
    feedback_dropped: int


class ActionList(Schema):
    """The actions on the graph."""

    actions: list[ActionInfo]


class Health(Schema):
    """Whether the gateway itself works; `node` is its name on the graph."""

    status: Literal["ok", "ros_unavailable"]
    version: str
    node: str
    ros: dict[str, str]
    subscribers: int


class HistoryState(Schema):
    """The state of the history of goals and events.

    `waiting` (in memory) and `spooled` (on disk) count what is not in the database yet; `dropped` counts the feedback
    and battery events that were discarded.
    """

    waiting: int
    spooled: int
    dropped: int
    database_reachable: bool
    last_error: str | None


class Readiness(Schema):
    """Whether the action server is available and answers, with the state of the history and of the stop."""

    ready: bool
    action_server: ActionServer
    history: HistoryState
    stop: StopState


class FieldProblem(Schema):
    """One invalid field."""

    path: str
    expected: str
    detail: str


class Problem(BaseModel):
    """RFC 9457 problem document."""

    type: str
    title: str
    status: int
    code: str
    detail: str
    errors: list[FieldProblem] | None = None
    goal_id: str | None = None


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


class ActionStatusEvent(GoalState):
    """The state of a goal on any action changed."""

    type: Literal["status"]
    id: str
    time: datetime
    goal: dict[str, Any] | None


class ActionFeedbackEvent(Schema):
    """Feedback of a goal on any action."""

    type: Literal["feedback"]
    id: str
    time: datetime
    goal_id: str
    action_name: str
    feedback: dict[str, Any]


class ActionResultEvent(Schema):
    """A goal on any action ended."""

    type: Literal["result"]
    id: str
    time: datetime
    goal_id: str
    action_name: str
    status: GoalStatus
    result: dict[str, Any] | None
    error: GoalError | None


class GoalHistory(Schema):
    """The events of a goal, oldest first.

    `next_after` is null on the last page. `complete` is false if events are missing.
    """

    events: list[ActionStatusEvent | ActionFeedbackEvent | ActionResultEvent]
    next_after: str | None
    complete: bool


class ExportedGoal(ActionGoal):
    """A goal with its events, oldest first; `complete` is false if events are missing."""

    complete: bool
    events: list[ActionStatusEvent | ActionFeedbackEvent | ActionResultEvent]
