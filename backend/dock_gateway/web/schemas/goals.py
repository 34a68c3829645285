"""The shapes of requests and answers, for the OpenAPI document and the types generated from it.

Nothing is validated or encoded with these at run time: messages come and go as the ROS definitions have them.
"""

from datetime import datetime
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict

from dock_gateway.core.goal import GoalStatus
from dock_gateway.fleet.alert_rules import AlertKind


class Schema(BaseModel):
    """Every field is always there."""

    model_config = ConfigDict(json_schema_serialization_defaults_required=True, extra="forbid")


class BatteryState(Schema):
    """sensor_msgs/BatteryState; the document gets its fields from the ROS definition (api/openapi.py)."""


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
    """What is known of any goal, without its messages."""

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
    """What a stop could not do: cancel the goals of an action, or publish zero velocity to a robot."""

    action_name: str | None
    robot: str | None
    code: str
    detail: str


class StopState(Schema):
    """Whether a stop is latched for a robot, since when and by whom; `robots` at or below it are held by a stop.

    `persisted`: false where the gateway could not store its latest stop or release, so that a restart would forget it.
    """

    latched: bool
    since: datetime | None
    by: str | None
    robots: list[str]
    persisted: bool


class StopReport(Schema):
    """What a stop did; the actions in `unconfirmed` were asked to cancel their goals and have not answered yet.

    `warning`: what of the request could not be read, and was left out; or that the stop is not stored yet.
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
    """The message as it went out."""

    state: BatteryState


class Publisher(Schema):
    """What is being published."""

    active: bool
    state: BatteryState | None
    rate_hz: float | None
    published_count: int
    started_at: datetime | None


class ActionServer(Schema):
    """Whether an action server is on the graph, and answers. `duplicate`: there is more than one."""

    action_name: str
    available: bool
    answering: bool
    duplicate: bool


class RobotBattery(Schema):
    """The latest battery state, without its age: it was received then."""

    state: BatteryState | None
    received_at: datetime | None
    stale: bool
    stale_after_s: float


class RobotPublisher(Schema):
    """Whether the gateway publishes a battery state for the robot, and how often."""

    active: bool
    rate_hz: float | None


class Robot(Schema):
    """A robot at a glance.

    `docked` is null where nobody knows; `dock` and `undock` where it has no such action. `goals` run on its actions;
    `last_goal` is the last one of docking and undocking that ended.
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
    """Who has seen an alert, and when."""

    by: str
    at: datetime


class Alert(Schema):
    """Something that an operator has to know of.

    `robot` is the robot, the namespace of an action that belongs to none, or null where the gateway itself is
    concerned. `detail` says what to do.
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
    """The alerts, critical ones first, then the oldest first."""

    alerts: list[Alert]


class ActionInfo(ActionServer):
    """An action on the graph; `hint` says what to install where its package is missing."""

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
    """How the keeping of goals and events goes.

    `waiting` in memory and `spooled` on disk are not in the database yet; `dropped` feedback and battery events were
    given up.
    """

    waiting: int
    spooled: int
    dropped: int
    database_reachable: bool
    last_error: str | None


class Readiness(Schema):
    """Whether a goal sent now would be heard."""

    ready: bool
    action_server: ActionServer
    history: HistoryState
    stop: StopState


class FieldProblem(Schema):
    """One field that is wrong."""

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
    """A simulated robot.

    `contact`: it touches its dock with its contacts; `docked`: and is charged there. `battery_publisher`: `self`, or
    `other` while someone else publishes the battery's state.
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
    """The events of a goal, oldest first; `next_after` where there are more, `complete` where none was given up."""

    events: list[ActionStatusEvent | ActionFeedbackEvent | ActionResultEvent]
    next_after: str | None
    complete: bool


class ExportedGoal(ActionGoal):
    """A goal with its events, oldest first; `complete` where none was given up."""

    complete: bool
    events: list[ActionStatusEvent | ActionFeedbackEvent | ActionResultEvent]
