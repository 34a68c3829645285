"""What the API takes and returns about missions."""

from datetime import datetime
from typing import Annotated, Any, Literal, Self

from pydantic import ConfigDict, Field, JsonValue, model_validator

from dock_gateway.core.event import utc_now
from dock_gateway.extensions.missions.battery import BatteryLimits
from dock_gateway.extensions.missions.mission import (
    PRIORITY,
    MissionEntry,
    MissionFields,
    MissionStatus,
    Priority,
    RechargeStage,
)
from dock_gateway.extensions.missions.moves import WaitsFor
from dock_gateway.extensions.missions.program import MAX_STEPS, compile_steps
from dock_gateway.extensions.missions.step import StepFields
from dock_gateway.extensions.missions.step_entry import Reason, StepPlace, StepStatus
from dock_gateway.extensions.missions.step_kinds import Waypoint, require_one
from dock_gateway.extensions.missions.templates.parameters import MAX_PARAMETERS
from dock_gateway.extensions.missions.templates.templates import Filled
from dock_gateway.http.bodies import GroupName, Name60, Slug, expected
from dock_gateway.http.resource import Versioned
from dock_gateway.http.schema import Schema

EXAMPLE: JsonValue = {
    "name": "Night",
    "steps": [
        {"dock": {}, "tries": 3},
        {"wait": {"battery": 0.8}},
        {"undock": {}},
        {"action": {"name": "/fibonacci", "goal": {"order": 5}}, "timeout_s": 60, "on_failure": "next"},
    ],
}


# The form of a `mission_id`.
MISSION_ID = "^[0-9a-f]{32}$"
MissionIdText = Annotated[str, Field(pattern=MISSION_ID)]
TEMPLATE_EXAMPLE: JsonValue = {"template": "fetch", "arguments": {"shelf": "shelf-a3"}}


class MissionContent(Schema):
    """What a mission is: `steps`, or a `template` by its id, with `arguments` for its parameters.

    `name`, `priority` and `battery` are those of the template by default; without one, `priority` is 50.
    """

    name: Name60 | None = None
    priority: Priority | None = None
    battery: BatteryLimits | None = None
    steps: Annotated[list[StepFields], Field(min_length=1, max_length=MAX_STEPS)] | None = None
    template: Slug | None = None
    arguments: Annotated[dict[str, Any], Field(max_length=MAX_PARAMETERS)] | None = None

    @model_validator(mode="after")
    def _is_one(self) -> Self:
        require_one(self, "steps", "template")
        if self.arguments is not None and self.template is None:
            raise expected("no arguments: they are for a template", path="arguments")
        return self

    def entry(
        self, robot: str | None, filled: Filled | None = None, by: str | None = None, group: str | None = None
    ) -> MissionEntry:
        """Return the mission, queued now.

        Args:
            robot: Its robot; None if one of a group takes it.
            filled: What it is made of by its template, if it has one.
            by: Who queues it.
            group: That group.

        Raises:
            InvalidField: As `compile_steps`.
        """
        now = utc_now()
        made = filled or Filled(self.steps or [], None, PRIORITY, {})
        return MissionEntry(
            robot=robot,
            group=group,
            name=self.name or made.name,
            priority=made.priority if self.priority is None else self.priority,
            battery=self.battery or made.battery,
            status=MissionStatus.QUEUED,
            held_for=None,
            step=0,
            error=None,
            template=self.template,
            arguments=None if self.template is None else self.arguments or {},
            created_by=by,
            created_at=now,
            started_at=None,
            finished_at=None,
            steps=compile_steps(made.steps),
        )


class MissionBody(MissionContent):
    """A mission: steps that the robot takes one after the other, or a template that has them.

    With `group`, it is for whichever robot of a group is free. Of those that wait for a robot, the one with the highest
    `priority` begins first, then the oldest, unless one was moved.
    """

    model_config = ConfigDict(json_schema_extra={"examples": [EXAMPLE, TEMPLATE_EXAMPLE]})

    group: GroupName | None = None
    by: Name60 | None = None


class MoveBody(Schema):
    """Where a mission goes in its queue: right `before` or `after` another one, by its `mission_id`."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"before": 32 * "0"}]})

    before: MissionIdText | None = None
    after: MissionIdText | None = None

    @model_validator(mode="after")
    def _names_one(self) -> Self:
        require_one(self, "before", "after")
        return self


class MissionStep(StepPlace):
    """A step, and how far it has come. Steps that are inside of it come behind it.

    `attempt` is the number of the present try, `goal_id` its goal once that was accepted, and `error` says what the
    last try ended with. `drives_to` is where the place that it names was when that try began.
    """

    status: StepStatus
    attempt: int
    drives_to: Waypoint | None
    goal_id: str | None
    started_at: datetime | None
    finished_at: datetime | None
    error: Reason | None


class MissionRecharge(Schema):
    """A break of a mission for the battery of its robot, which goes on with its step afterwards.

    `tried` counts the tries that have failed, `goal_id` is the goal that docks or undocks the robot, and `error` says
    what the last try ended with.
    """

    number: int
    stage: RechargeStage
    started_at: datetime
    tried: int
    goal_id: str | None
    error: Reason | None


class Mission(MissionFields, Versioned):
    """A mission.

    `held_for` says why it does not go on until somebody continues it, and `waits_for` what it waits for otherwise; null
    if that is not known, or it has ended. `recharge` is its break for the battery of its robot; null: it
    is at its step.
    """

    mission_id: str
    waits_for: WaitsFor | None
    recharge: MissionRecharge | None
    steps: list[MissionStep]


class MissionList(Schema):
    """Missions, newest first."""

    missions: list[Mission]
    next_cursor: str | None


class MissionEvent(Schema):
    """A mission is new, or has changed."""

    type: Literal["mission"]
    time: datetime
    mission: Mission


# What streams can ask for.
EVENTS = (MissionEvent,)
