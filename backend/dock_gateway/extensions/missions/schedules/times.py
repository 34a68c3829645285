"""When a schedule is due: once, at times of day, or every so many minutes. Rules over plain data, without a clock."""

from collections.abc import Iterator
from datetime import UTC, date, datetime, time, timedelta
from typing import Annotated
from zoneinfo import ZoneInfo

from pydantic import Field, Strict

from dock_gateway.http.queries import TIME_PATTERN, Time
from dock_gateway.http.schema import Schema
from dock_gateway.http.times_of_day import WEEKDAYS, TimesOfDay, Weekday, Weekdays, Zone

SECOND, DAY = timedelta(seconds=1), timedelta(days=1)
# Days on each side of one within which each weekday comes, also where a day is left out.
NEAR = 9
A_WEEK = 10_080  # minutes


class Once(Schema):
    """Once, at a time."""

    due_at: Annotated[Time, Strict(False), Field(json_schema_extra=TIME_PATTERN)]

    def next(self, after: datetime, _: datetime) -> datetime | None:
        """Return the first time that is later than another one."""
        return self.due_at if self.due_at > after else None

    def last(self, now: datetime, _: datetime) -> datetime | None:
        """Return the last time that is not later than another one."""
        return self.due_at if self.due_at <= now else None


class Every(Schema):
    """Every so many `minutes`, for the first time that long after the schedule was stored."""

    minutes: Annotated[int, Field(ge=1, le=A_WEEK)]

    @property
    def _step(self) -> timedelta:
        return timedelta(minutes=self.minutes)

    def next(self, after: datetime, since: datetime) -> datetime | None:
        """Return the first time that is later than another one; `since` is when the schedule was stored."""
        return since + max(1, (after - since) // self._step + 1) * self._step

    def last(self, now: datetime, since: datetime) -> datetime | None:
        """Return the last time that is not later than another one; None if there is none."""
        count = (now - since) // self._step
        return since + count * self._step if count >= 1 else None


class Daily(Schema):
    """Times of day, HH:MM in a time zone, on some days of the week, by default on each.

    A time that does not occur, as clocks go forward, is the first moment after it that does. One that occurs twice, as
    they go back, is the first of the two.
    """

    times: TimesOfDay
    weekdays: Weekdays = Field(default_factory=lambda: list[Weekday](WEEKDAYS))
    time_zone: Zone

    def next(self, after: datetime, _: datetime) -> datetime | None:
        """Return the first time that is later than another one."""
        return next((each for day in self._days(after, 1) for each in self.moments(day) if each > after), None)

    def last(self, now: datetime, _: datetime) -> datetime | None:
        """Return the last time that is not later than another one."""
        return next((each for day in self._days(now, -1) for each in self.moments(day)[::-1] if each <= now), None)

    def _days(self, moment: datetime, step: int) -> Iterator[date]:
        """Yield the days around a moment, in order; those before it last if `step` is -1."""
        today = moment.astimezone(ZoneInfo(self.time_zone)).date()
        for offset in range(-2, NEAR):
            yield today + step * offset * DAY

    def moments(self, day: date) -> list[datetime]:
        """Return when it is due on a day, in UTC, in order."""
        if WEEKDAYS[day.weekday()] not in self.weekdays:
            return []
        zone = ZoneInfo(self.time_zone)
        return sorted({moment_of(datetime.combine(day, time.fromisoformat(each)), zone) for each in self.times})


def moment_of(local: datetime, zone: ZoneInfo) -> datetime:
    """Return the moment, in UTC, of a time on the clocks of a time zone: see `Daily`.

    Args:
        local: The time, in whole seconds, without a time zone.
        zone: The time zone.
    """
    late, early = (local.replace(tzinfo=zone, fold=fold).astimezone(UTC) for fold in (0, 1))
    if _clock(late, zone) == local:
        return late
    while late - early > SECOND:  # the clocks go forward between the two
        middle = early + (late - early) // (2 * SECOND) * SECOND
        if _clock(middle, zone) < local:
            early = middle
        else:
            late = middle
    return late


def _clock(moment: datetime, zone: ZoneInfo) -> datetime:
    return moment.astimezone(zone).replace(tzinfo=None)
