"""Times of day: when a rule is due. Pure."""

from collections.abc import Iterator
from datetime import UTC, datetime, timedelta
from zoneinfo import ZoneInfo

from dock_gateway.core.automation import WEEKDAYS, Rule

DAY = timedelta(days=1)


def last_due(rule: Rule, now: datetime) -> datetime | None:
    """Return the last time, in UTC, at which a rule was due within the last day or so; None if it was not."""
    return max((time for time in _around(rule, now) if time <= now), default=None)


def next_due(rule: Rule, now: datetime) -> datetime | None:
    """Return the next time, in UTC, at which a rule is due within the next day or so; None if it is not."""
    return min((time for time in _around(rule, now) if time > now), default=None)


def _around(rule: Rule, now: datetime) -> Iterator[datetime]:
    """Yield the times at which a rule is due yesterday, today and tomorrow.

    Each time of a day is one moment: a time that occurs twice, as clocks go back, is the first of them, and one that
    does not occur, as they go forward, is later by the difference.
    """
    zone = ZoneInfo(rule.time_zone or "UTC")
    today = now.astimezone(zone).date()
    for date in (today - DAY, today, today + DAY):
        if WEEKDAYS[date.weekday()] in rule.weekdays:
            for time in rule.times:
                hour, minute = map(int, time.split(":"))
                local = datetime(date.year, date.month, date.day, hour, minute, tzinfo=zone)
                yield local.astimezone(UTC)
