"""Times of day: when a schedule is due. Pure."""

from collections.abc import Iterator
from datetime import UTC, datetime, timedelta
from zoneinfo import ZoneInfo

from dock_gateway.extensions.automation.rule import Schedule
from dock_gateway.http.times_of_day import WEEKDAYS

DAY = timedelta(days=1)


def last_due(schedule: Schedule, now: datetime) -> datetime | None:
    """Return the last time, in UTC, at which a schedule was due within the last day or so; None if it was not."""
    return max((time for time in _around(schedule, now) if time <= now), default=None)


def next_due(schedule: Schedule, now: datetime) -> datetime | None:
    """Return the next time, in UTC, at which a schedule is due within the next day or so; None if it is not."""
    return min((time for time in _around(schedule, now) if time > now), default=None)


def _around(schedule: Schedule, now: datetime) -> Iterator[datetime]:
    """Yield the times at which a schedule is due yesterday, today and tomorrow.

    Each time of a day is one moment: a time that occurs twice, as clocks go back, is the first of them, and one that
    does not occur, as they go forward, is later by the difference.
    """
    zone = ZoneInfo(schedule.time_zone)
    today = now.astimezone(zone).date()
    for date in (today - DAY, today, today + DAY):
        if WEEKDAYS[date.weekday()] in schedule.weekdays:
            for time in schedule.times:
                hour, minute = map(int, time.split(":"))
                local = datetime(date.year, date.month, date.day, hour, minute, tzinfo=zone)
                yield local.astimezone(UTC)
