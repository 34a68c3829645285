"""The JSON shapes of the overview of robots, their labels and alerts."""

from datetime import datetime
from enum import StrEnum
from typing import Annotated, Literal

from pydantic import ConfigDict, Field, JsonValue

from dock_gateway.fleet.alert_kinds import CORE_KINDS
from dock_gateway.goals.action_schema import ActionServer
from dock_gateway.goals.schema import GoalState
from dock_gateway.http.bodies import GroupName, Name60, Unique
from dock_gateway.http.resource import Versioned
from dock_gateway.http.schema import MAX_GROUPS, RosName, Schema
from dock_gateway.robots.schema import Battery
from dock_gateway.stop.schema import StopState

AlertKind = StrEnum("AlertKind", [(kind.value.upper(), kind.value) for kind in CORE_KINDS])  # type: ignore[misc]
AlertKind.__doc__ = "The kinds of alerts."


class RobotPublisher(Schema):
    """Whether the gateway publishes a battery state for the robot, and how often."""

    active: bool
    rate_hz: float | None


class RobotJoin(Schema):
    """Settings that give a robot a docking server in another namespace, as lines and as a sentence."""

    detail: str
    settings: list[str]


class Robot(Schema):
    """Summary of a robot.

    `name` is its namespace; `display_name` and `groups` are the label that `PUT /label` sets.
    `docked` is null if unknown, and so is `charging`: whether its battery is charged or full. `dock` and `undock` are
    null if the robot has no such action. `goals` are those running on its actions; `last_goal` is the last docking or
    undocking goal that ended. `join` is null unless the robot has a battery and no docking server, and one
    without a battery is in another namespace.
    """

    name: RosName
    display_name: str | None
    groups: list[str]
    default: bool
    docked: bool | None
    charging: bool | None
    simulated: bool
    battery: Battery
    battery_topic: RosName
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


LABEL_EXAMPLE: JsonValue = {"display_name": "Left forklift", "groups": ["hall 1", "forklifts"]}


class LabelBody(Schema):
    """The display name of a robot, null if it has none, and the groups that it is in."""

    model_config = ConfigDict(json_schema_extra={"examples": [LABEL_EXAMPLE]})

    display_name: Annotated[Name60 | None, Field(description="Belongs to one robot, whatever its case")]
    groups: Annotated[tuple[GroupName, ...], Field(max_length=MAX_GROUPS), Unique]


class Label(Versioned):
    """The label of a robot, which need not be on the ROS graph."""

    robot: str
    display_name: str | None
    groups: list[str]


class AcknowledgementBody(Schema):
    """An acknowledgement of an alert. `by` is who has seen it."""

    by: Name60


class Acknowledgement(Schema):
    """Who acknowledged an alert, and when."""

    by: str
    acknowledged_at: datetime


class Alert(Versioned):
    """A condition that an operator has to know about.

    `robot` is the robot, the namespace of an action that belongs to no robot, or null for the gateway itself. `detail`
    says what to do.
    """

    id: str
    kind: AlertKind
    robot: RosName | None
    severity: Literal["critical", "warning"]
    started_at: datetime
    title: str
    detail: str
    goal_id: str | None
    acknowledged: Acknowledgement | None


class AlertList(Schema):
    """The active alerts: critical ones first, then oldest first."""

    alerts: list[Alert]
