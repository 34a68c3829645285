"""The JSON shapes of the agents' tools: what they take and what they return."""

from datetime import datetime
from typing import Annotated, Any

from pydantic import Field

from dock_gateway.core.goal import GoalStatus
from dock_gateway.http.schema import Schema

# Seconds that a call waits for the end of a goal: by default, and at most.
WAIT, MAX_WAIT = 120.0, 600.0

Robot = Annotated[
    str | None,
    Field(description="Namespace of the robot, such as `/robot1`, as `list_robots` names it. Default: the only robot."),
]
GoalId = Annotated[str, Field(description="`goal_id` of the goal, as the other tools return it")]
Wait = Annotated[
    float,
    Field(ge=0, le=MAX_WAIT, description="Seconds to wait for the end of the goal. The goal goes on after that."),
]
Key = Annotated[
    str | None,
    Field(
        description="A text of your choice, new for each goal. Repeat a call that failed with the same text: "
        "the goal is then sent only once.",
        max_length=200,
    ),
]


class OfRobot(Schema):
    """A robot, or all."""

    robot: Annotated[str | None, Field(description="Only this robot: a namespace such as `/robot1`")] = None


class OfAction(Schema):
    """An action."""

    action: Annotated[str, Field(description="Name of the action, such as `/fibonacci`, as `list_actions` names it")]


class DockArguments(Schema):
    """The arguments of `dock_robot`."""

    robot: Robot = None
    dock_id: Annotated[
        str | None, Field(description="Name of the dock, where the robot knows several. Default: its own dock.")
    ] = None
    wait_seconds: Wait = WAIT
    idempotency_key: Key = None


class UndockArguments(Schema):
    """The arguments of `undock_robot`."""

    robot: Robot = None
    wait_seconds: Wait = WAIT
    idempotency_key: Key = None


class SendArguments(OfAction):
    """The arguments of `send_goal`."""

    goal: Annotated[dict[str, Any], Field(description="The goal message. `describe_action` has its JSON Schema.")]
    wait_seconds: Wait = WAIT
    idempotency_key: Key = None


class WaitArguments(Schema):
    """The arguments of `wait_for_goal`."""

    goal_id: GoalId
    wait_seconds: Wait = WAIT


class OfGoal(Schema):
    """A goal."""

    goal_id: GoalId


class ListGoalsArguments(Schema):
    """The arguments of `list_goals`."""

    robot: Annotated[str | None, Field(description="Only goals of this robot")] = None
    action: Annotated[str | None, Field(description="Only goals on this action")] = None
    status: Annotated[GoalStatus | None, Field(description="Only goals in this state")] = None
    limit: Annotated[int, Field(ge=1, le=100, description="Number of goals, newest first")] = 20


class StopArguments(Schema):
    """The arguments of `stop_robots`."""

    robot: Annotated[str | None, Field(description="Only this robot and those below it. Default: every robot.")] = None


class GoalError(Schema):
    """Why a goal did not succeed."""

    code: str
    detail: str


class Goal(Schema):
    """A goal. `ended` says whether it has ended; `result` and `feedback` are messages of its action."""

    goal_id: str
    action_name: str
    status: GoalStatus
    ended: bool
    stage: str | None
    retries: int | None
    created_at: datetime
    finished_at: datetime | None
    error: GoalError | None
    goal: Any
    feedback: Any
    result: Any


class GoalAnswer(Schema):
    """A goal, as it is now."""

    goal: Goal


class GoalList(Schema):
    """Goals, newest first."""

    goals: list[Goal]


class Explanation(Schema):
    """Why a goal ended as it did, and the changes of its state, oldest first."""

    explanation: str
    goal: Goal
    events: list[dict[str, Any]]


class RobotState(Schema):
    """A robot. `battery_percent` is from 0 to 100.

    `stopped`: it takes no goals until a supervisor releases the stop, which no tool can do.
    """

    name: str
    display_name: str | None
    simulated: bool
    docked: bool | None
    charging: bool | None
    battery_percent: float | None
    stopped: bool
    stopped_by: str | None
    can_dock: bool
    can_undock: bool
    running_goals: list[str]


class RobotList(Schema):
    """The robots."""

    robots: list[RobotState]


class ActionState(Schema):
    """An action. `verb` says whether it docks or undocks a robot; `hint` what is missing if it cannot be used."""

    action_name: str
    action_type: str
    verb: str | None
    available: bool
    running_goals: int
    hint: str | None


class ActionList(Schema):
    """The actions."""

    actions: list[ActionState]


class ActionMessages(Schema):
    """An action type: the JSON Schema of its goal, result and feedback."""

    action_name: str
    action_type: str
    goal: dict[str, Any]
    result: dict[str, Any]
    feedback: dict[str, Any]


class AlertState(Schema):
    """A condition that an operator has to know about."""

    id: str
    kind: str
    robot: str | None
    severity: str
    started_at: datetime
    title: str
    detail: str


class AlertList(Schema):
    """The active alerts: critical ones first."""

    alerts: list[AlertState]


class StopAnswer(Schema):
    """What became of a stop. `stopped` and `not_stopped` name robots, `canceling` and `unconfirmed` goals.

    `failed` names what could not be reached.

    `others` are gateways that stop robots of their own then.
    """

    stopped: Any
    not_stopped: Any
    stop: Any
    canceling: Any
    unconfirmed: Any
    failed: Any
    others: Any
    warning: Any
