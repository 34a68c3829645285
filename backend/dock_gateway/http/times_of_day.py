"""Times of day, days of the week and time zones in bodies."""

import re
from typing import Annotated, Literal, get_args
from zoneinfo import ZoneInfo

from pydantic import AfterValidator, Field

from dock_gateway.http.bodies import expected

ZONE = re.compile(r"[A-Za-z][A-Za-z0-9_+-]*(?:/[A-Za-z0-9_+-]+){0,2}")
MAX_ZONE = 60


def _check_zone(name: str) -> str:
    try:
        if len(name) <= MAX_ZONE and ZONE.fullmatch(name):
            ZoneInfo(name)
            return name
    except (KeyError, ValueError, OSError):  # a folder or another file is not a time zone, either
        pass
    raise expected("an IANA time zone, such as Europe/Berlin")


def _sorted(times: list[str]) -> list[str]:
    return sorted(set(times))


Weekday = Literal["mon", "tue", "wed", "thu", "fri", "sat", "sun"]
WEEKDAYS: tuple[Weekday, ...] = get_args(Weekday)


def _in_order(weekdays: list[Weekday]) -> list[Weekday]:
    return [day for day in WEEKDAYS if day in weekdays]


# HH:MM.
TimeOfDay = Annotated[str, Field(pattern=r"^(?:[01][0-9]|2[0-3]):[0-5][0-9]$")]
TimesOfDay = Annotated[list[TimeOfDay], Field(min_length=1, max_length=24), AfterValidator(_sorted)]
Weekdays = Annotated[list[Weekday], Field(min_length=1, max_length=7), AfterValidator(_in_order)]
Zone = Annotated[
    str,
    AfterValidator(_check_zone),
    Field(
        description="IANA name, such as Europe/Berlin",
        json_schema_extra={"maxLength": MAX_ZONE, "pattern": f"^{ZONE.pattern}$"},
    ),
]
