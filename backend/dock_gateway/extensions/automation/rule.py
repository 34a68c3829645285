"""A rule of automatic docking: what clients send and get, and what is stored. A new field is declared here alone."""

import re
from datetime import datetime
from typing import Annotated, Literal, Self, get_args
from zoneinfo import ZoneInfo

from pydantic import AfterValidator, ConfigDict, Field, JsonValue, model_validator

from dock_gateway.core.event import utc_now
from dock_gateway.extensions.automation.decision import RuleMode
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
WEEKDAYS: tuple[Weekday, ...] = get_args(Weekday)
Zone = Annotated[
    str,
    AfterValidator(_check_zone),
    Field(
        description="IANA name, such as Europe/Berlin",
        json_schema_extra={"maxLength": MAX_ZONE, "pattern": f"^{ZONE.pattern}$"},
    ),
]


def _sorted(times: list[str]) -> list[str]:
    return sorted(set(times))


def _in_order(weekdays: list[Weekday]) -> list[Weekday]:
    return [day for day in WEEKDAYS if day in weekdays]


class Schedule(Schema):
    """Times of day, HH:MM, on some days of the week in a time zone."""

    times: Annotated[list[Time], Field(min_length=1, max_length=24), AfterValidator(_sorted)]
    weekdays: Annotated[list[Weekday], Field(min_length=1, max_length=7), AfterValidator(_in_order)]
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
