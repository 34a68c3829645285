"""A schedule: what clients send and get, and what is stored."""

from datetime import datetime
from enum import StrEnum
from typing import Self

from pydantic import ConfigDict, JsonValue, model_validator

from dock_gateway.extensions.missions.schedules.times import Daily, Every, Once
from dock_gateway.extensions.missions.schema import MissionContent
from dock_gateway.extensions.missions.step_kinds import require_one
from dock_gateway.http.bodies import GroupName, Name60, RobotName, expected
from dock_gateway.http.resource import Versioned
from dock_gateway.http.schema import RosName, Schema

EXAMPLE: JsonValue = {
    "name": "Night round",
    "robot": "/robot1",
    "mission": {"template": "fetch", "arguments": {"shelf": "shelf-a3"}},
    "daily": {"times": ["22:00"], "weekdays": ["mon", "fri"], "time_zone": "Europe/Berlin"},
    "by": "Ada",
}
EVERY_EXAMPLE: JsonValue = {"mission": {"steps": [{"undock": {}}, {"dock": {}}]}, "every": {"minutes": 90}}


class IfRunning(StrEnum):
    """What happens at a time at which a mission of the schedule has not ended: none is queued, or another one."""

    SKIP = "skip"
    QUEUE = "queue"


class ScheduleOutcome(Schema):
    """What came of the last time: `mission_id`, or why no mission was queued."""

    due_at: datetime
    decided_at: datetime
    mission_id: str | None = None
    code: str | None = None
    detail: str | None = None


class ScheduleFields(Schema):
    """The fields of a schedule. One of `once`, `daily` and `every` says when; `name` is shown instead of its id.

    `group`: a robot of this group takes each of its missions, whichever is free; null: its robot does.
    """

    name: Name60 | None = None
    enabled: bool = True
    group: GroupName | None = None
    mission: MissionContent
    once: Once | None = None
    daily: Daily | None = None
    every: Every | None = None
    if_running: IfRunning = IfRunning.SKIP

    @model_validator(mode="after")
    def _is_one(self) -> Self:
        require_one(self, "once", "daily", "every")
        return self

    @property
    def times(self) -> Once | Daily | Every:
        """When it is due."""
        times = self.once or self.daily or self.every
        if times is None:
            raise AssertionError("it has none")
        return times


class ScheduleState(ScheduleFields):
    """A schedule, and what came of it. `robot` is that of its missions; null if they are for a group."""

    robot: RosName | None
    last: ScheduleOutcome | None = None
    changed_by: str | None
    changed_at: datetime


class ScheduleEntry(ScheduleState):
    """A schedule as it is stored.

    Attributes:
        after: Until when everything is decided, or does not count: it was stored then.
    """

    after: datetime

    @property
    def next_due(self) -> datetime | None:
        """The first time that is not decided; None: there is none, or it is off."""
        return self.times.next(self.after, self.changed_at) if self.enabled else None

    def decided(self, outcome: ScheduleOutcome) -> "ScheduleEntry":
        """Return the schedule after a time."""
        return self.model_copy(update={"after": outcome.due_at, "last": outcome})


class ScheduleBody(ScheduleFields):
    """A schedule that is stored; without a `robot` and a `group` for the configured robot. `by` is who changes it."""

    model_config = ConfigDict(json_schema_extra={"examples": [EXAMPLE, EVERY_EXAMPLE]})

    robot: RobotName | None = None
    by: Name60 | None = None

    @model_validator(mode="after")
    def _is_for_one(self) -> Self:
        if self.robot is not None and self.group is not None:
            raise expected("a robot or a group", "got both", path="group")
        return self

    def entry(self, robot: str | None, now: datetime, last: ScheduleOutcome | None) -> ScheduleEntry:
        """Return the schedule, changed now. What was due before does not count.

        Args:
            robot: The namespace of its robot; None: it is for its group.
            now: The time.
            last: What came of it before.
        """
        fields = {name: getattr(self, name) for name in ScheduleFields.model_fields}
        return ScheduleEntry(**fields, robot=robot, last=last, changed_by=self.by, changed_at=now, after=now)


class MissionSchedule(ScheduleState, Versioned):
    """Queues missions by itself. `next_at` is the next time; null: there is none, or it is off."""

    id: str
    next_at: datetime | None


class MissionScheduleList(Schema):
    """The schedules, by id."""

    schedules: list[MissionSchedule]
