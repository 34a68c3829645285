"""What the API takes and returns about missions."""

from datetime import datetime
from typing import Annotated, Literal

from pydantic import ConfigDict, Field, JsonValue

from dock_gateway.core.event import utc_now
from dock_gateway.extensions.missions.mission import (
    MissionEntry,
    MissionFields,
    MissionStatus,
    Reason,
    StepPlace,
    StepStatus,
)
from dock_gateway.extensions.missions.moves import WaitsFor
from dock_gateway.extensions.missions.program import MAX_STEPS, compile_steps
from dock_gateway.extensions.missions.step import StepFields
from dock_gateway.extensions.missions.step_kinds import Waypoint
from dock_gateway.http.bodies import Name60
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


class MissionBody(Schema):
    """A mission: steps that the robot takes one after the other.

    Of those that wait for a robot, the one with the highest `priority` begins first, then the oldest.
    """

    model_config = ConfigDict(json_schema_extra={"examples": [EXAMPLE]})

    name: Name60 | None = None
    priority: Annotated[int, Field(ge=0, le=100)] = 50
    steps: Annotated[list[StepFields], Field(min_length=1, max_length=MAX_STEPS)]
    by: Name60 | None = None

    def entry(self, robot: str) -> MissionEntry:
        """Return the mission, queued now.

        Raises:
            InvalidField: As `compile_steps`.
        """
        now = utc_now()
        return MissionEntry(
            robot=robot,
            name=self.name,
            priority=self.priority,
            status=MissionStatus.QUEUED,
            held_for=None,
            step=0,
            error=None,
            created_by=self.by,
            created_at=now,
            started_at=None,
            finished_at=None,
            steps=compile_steps(self.steps),
        )


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


class Mission(MissionFields):
    """A mission.

    `held_for` says why it does not go on until somebody continues it, and `waits_for` what it waits for otherwise; null
    if that is not known, or it has ended.
    """

    mission_id: str
    waits_for: WaitsFor | None
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
