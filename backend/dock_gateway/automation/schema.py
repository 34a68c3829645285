"""The JSON shapes of automatic docking: rules and decisions."""

import re
from datetime import datetime
from typing import Annotated, Literal, Self
from zoneinfo import ZoneInfo

from pydantic import AfterValidator, ConfigDict, Field, JsonValue, model_validator

from dock_gateway.core import automation as stored
from dock_gateway.core.automation import Mode, Outcome, Wait
from dock_gateway.core.event import utc_now
from dock_gateway.http.bodies import Name60, expected
from dock_gateway.http.schema import RobotSelection, Schema

ZONE = re.compile(r"[A-Za-z][A-Za-z0-9_+-]*(?:/[A-Za-z0-9_+-]+){0,2}")
MAX_ZONE = 60

RULE_EXAMPLE: JsonValue = {
    "name": "Low battery",
    "mode": "dry_run",
    "robots": {"all": False, "names": ["/robot1"], "groups": ["hall 1"]},
    "battery": {"below": 0.2, "idle_s": 60},
    "by": "Ada",
}
SCHEDULE_EXAMPLE: JsonValue = {
    "name": "Night",
    "robots": {"all": True},
    "schedule": {"times": ["22:00"], "weekdays": ["mon", "tue", "wed", "thu", "fri"], "time_zone": "Europe/Berlin"},
}


class BatteryCondition(Schema):
    """The battery has been below `below` (0 to 1), and the robot idle, for `idle_s` seconds."""

    below: Annotated[float, Field(gt=0, le=1, description="Charge, 0 to 1")]
    idle_s: Annotated[float, Field(ge=10, le=86_400, description="Seconds")]


def _check_zone(name: str) -> str:
    try:
        if len(name) <= MAX_ZONE and ZONE.fullmatch(name):
            ZoneInfo(name)
            return name
    except (KeyError, ValueError, OSError):  # a folder or another file is not a time zone, either
        pass
    raise expected("an IANA time zone, such as Europe/Berlin")


Time = Annotated[str, Field(pattern=r"^(?:[01][0-9]|2[0-3]):[0-5][0-9]$")]
Weekday = Literal["mon", "tue", "wed", "thu", "fri", "sat", "sun"]
Zone = Annotated[
    str,
    AfterValidator(_check_zone),
    Field(
        description="IANA name, such as Europe/Berlin",
        json_schema_extra={"maxLength": MAX_ZONE, "pattern": f"^{ZONE.pattern}$"},
    ),
]


class Schedule(Schema):
    """Times of day, HH:MM, on some days of the week in a time zone."""

    times: Annotated[list[Time], Field(min_length=1, max_length=24)]
    weekdays: Annotated[list[Weekday], Field(min_length=1, max_length=7)]
    time_zone: Zone


class RuleRobot(Schema):
    """A robot that a rule applies to now, and why it is not docked now."""

    robot: str
    waits_for: Wait


class RuleFields(Schema):
    """What makes a rule. Either `battery` or `schedule` is null."""

    name: Name60
    mode: Mode = Mode.OFF
    robots: RobotSelection
    battery: BatteryCondition | None = None
    schedule: Schedule | None = None

    @model_validator(mode="after")
    def _have_one_condition(self) -> Self:
        if (self.battery is None) is (self.schedule is None):
            detail = "got neither" if self.battery is None else "got both"
            raise expected("one condition, `battery` or `schedule`", detail, path="battery")
        return self


class RuleBody(RuleFields):
    """A rule that is stored. `by` is who changes it."""

    model_config = ConfigDict(json_schema_extra={"examples": [RULE_EXAMPLE, SCHEDULE_EXAMPLE]})

    by: Name60 | None = None

    def rule(self) -> stored.Rule:
        """Return the rule, changed now."""
        battery, schedule = self.battery, self.schedule
        return stored.Rule(
            name=self.name,
            mode=self.mode,
            every_robot=self.robots.all,
            robots=self.robots.names,
            groups=self.robots.groups,
            below=None if battery is None else battery.below,
            idle_s=None if battery is None else battery.idle_s,
            times=() if schedule is None else tuple(sorted(set(schedule.times))),
            weekdays=() if schedule is None else tuple(day for day in stored.WEEKDAYS if day in schedule.weekdays),
            time_zone=None if schedule is None else schedule.time_zone,
            changed_by=self.by,
            changed_at=utc_now(),
        )


class Rule(RuleFields):
    """A rule of automatic docking. Either `battery` or `schedule` is null.

    `applies_to` lists the robots on the gateway that it applies to.
    """

    id: str
    changed_by: str | None
    changed_at: datetime
    applies_to: list[RuleRobot]


class RuleList(Schema):
    """The rules, by name."""

    rules: list[Rule]


class Decision(Schema):
    """What a rule decided about a robot, and the facts that it went by.

    `battery` is the charge (0 to 1); `idle_since` is when the robot was idle with a low battery, or stood still before
    a time of day, which is `scheduled_for`. `code` and `detail` say why no goal was sent.
    """

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "id": "0b8f9b0e4e5c4c62a2ac3c2f5bd0a1f2",
                    "rule_id": "low-battery",
                    "rule_name": "Low battery",
                    "robot": "/robot1",
                    "at": "2026-11-21T21:04:12.182Z",
                    "outcome": "sent",
                    "battery": 0.18,
                    "idle_since": "2026-11-21T21:03:12.182Z",
                    "scheduled_for": None,
                    "goal_id": "6a8c2b0a-5c63-4d0e-9c1e-0d7a9c4d5e6f",
                    "code": None,
                    "detail": None,
                }
            ]
        }
    )

    id: str
    rule_id: str
    rule_name: str
    robot: str
    at: datetime
    outcome: Outcome
    battery: float | None
    idle_since: datetime | None
    scheduled_for: datetime | None
    goal_id: str | None
    code: str | None
    detail: str | None


class DecisionList(Schema):
    """Decisions, newest first."""

    decisions: list[Decision]
