"""A rule of automatic docking: what clients send and get, and what is stored. A new field is declared here alone."""

from datetime import datetime
from typing import Annotated, Self

from pydantic import ConfigDict, Field, JsonValue, model_validator

from dock_gateway.core.event import utc_now
from dock_gateway.extensions.automation.decision import RuleMode
from dock_gateway.http.bodies import Name60, expected
from dock_gateway.http.schema import RobotSelection, Schema
from dock_gateway.http.times_of_day import TimesOfDay, Weekdays, Zone

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


class Schedule(Schema):
    """Times of day, HH:MM, on some days of the week in a time zone."""

    times: TimesOfDay
    weekdays: Weekdays
    time_zone: Zone


class RuleFields(Schema):
    """The fields of a rule. Either `battery` or `schedule` is null."""

    name: Name60
    mode: RuleMode = RuleMode.OFF
    robots: RobotSelection
    battery: BatteryCondition | None = None
    schedule: Schedule | None = None

    @model_validator(mode="after")
    def _have_one_condition(self) -> Self:
        if (self.battery is None) is (self.schedule is None):
            detail = "got neither" if self.battery is None else "got both"
            raise expected("one condition, `battery` or `schedule`", detail, path="battery")
        return self


class RuleEntry(RuleFields):
    """A rule as it is stored: who changed it last, if known, and when."""

    changed_by: str | None
    changed_at: datetime


class RuleBody(RuleFields):
    """A rule that is stored. `by` is who changes it."""

    model_config = ConfigDict(json_schema_extra={"examples": [RULE_EXAMPLE, SCHEDULE_EXAMPLE]})

    by: Name60 | None = None

    def entry(self) -> RuleEntry:
        """Return the rule, changed now."""
        fields = {name: getattr(self, name) for name in RuleFields.model_fields}
        return RuleEntry(**fields, changed_by=self.by, changed_at=utc_now())
