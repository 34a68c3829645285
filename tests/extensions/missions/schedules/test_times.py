"""When schedules are due, over all time zones and the nights on which clocks change."""

from datetime import UTC, date, datetime, time, timedelta
from functools import cache
from zoneinfo import ZoneInfo, available_timezones

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from dock_gateway.extensions.missions.schedules.times import Daily, Every, Once, moment_of
from dock_gateway.http.times_of_day import WEEKDAYS, Weekday

MINUTE, DAY = timedelta(minutes=1), timedelta(days=1)
SINCE = datetime(2026, 1, 1, tzinfo=UTC)


def utc(text: str) -> datetime:
    return datetime.fromisoformat(text).replace(tzinfo=UTC)


def daily(zone: str, *times: str, weekdays: tuple[Weekday, ...] = WEEKDAYS) -> Daily:
    return Daily(times=[*times], weekdays=[*weekdays], time_zone=zone)


def series(times: Daily | Every | Once, after: datetime, until: datetime) -> list[datetime]:
    """Return all that is due within a time, one after the other."""
    found: list[datetime] = []
    while (due := times.next(after, SINCE)) is not None and due <= until:
        found.append(due)
        after = due
    return found


@pytest.mark.parametrize(
    ("times", "due"),
    [
        (("02:30",), ["2026-03-28T01:30", "2026-03-29T01:00", "2026-03-30T00:30"]),  # 02:30 is 03:00 that night
        (("02:00",), ["2026-03-28T01:00", "2026-03-29T01:00", "2026-03-30T00:00"]),
        (("02:15", "03:00"), ["2026-03-28T01:15", "2026-03-28T02:00", "2026-03-29T01:00", "2026-03-30T00:15"]),
    ],
)
def test_clocks_that_go_forward(times: tuple[str, ...], due: list[str]) -> None:
    found = series(daily("Europe/Berlin", *times), utc("2026-03-28T00:00"), utc("2026-03-30T00:59"))
    assert found == [utc(each) for each in due]


def test_clocks_that_go_back() -> None:
    found = series(daily("Europe/Berlin", "02:30"), utc("2026-10-24T00:00"), utc("2026-10-26T03:00"))
    assert found == [utc("2026-10-24T00:30"), utc("2026-10-25T00:30"), utc("2026-10-26T01:30")]
    half = series(daily("Australia/Lord_Howe", "01:45"), utc("2026-04-04T00:00"), utc("2026-04-05T12:00"))
    assert half == [utc("2026-04-04T14:45")]


def test_a_day_that_is_left_out() -> None:
    """Samoa had no 30 December 2011: what was due then is due as the next day begins."""
    found = series(daily("Pacific/Apia", "12:00"), utc("2011-12-29T12:00"), utc("2012-01-01T00:00"))
    assert found == [utc("2011-12-29T22:00"), utc("2011-12-30T10:00"), utc("2011-12-30T22:00"), utc("2011-12-31T22:00")]


def test_days_are_those_of_the_time_zone() -> None:
    monday = daily("Pacific/Auckland", "08:00", weekdays=("mon",))
    assert series(monday, utc("2026-06-01T00:00"), utc("2026-06-15T00:00")) == [
        utc("2026-06-07T20:00"),
        utc("2026-06-14T20:00"),
    ]
    assert monday.last(utc("2026-06-14T19:59"), SINCE) == utc("2026-06-07T20:00")


@cache
def zones() -> list[str]:
    return sorted(name for name in available_timezones() if name not in ("localtime", "Factory"))


ZONES = st.sampled_from(zones())
TIMES = st.lists(st.times().map(lambda each: f"{each:%H:%M}"), min_size=1, max_size=4, unique=True)
DAYS = st.lists(st.sampled_from(WEEKDAYS), min_size=1, unique=True).map(tuple)
MOMENTS = st.datetimes(datetime(1971, 1, 1), datetime(2100, 1, 1), timezones=st.just(UTC))  # noqa: DTZ001 - of `timezones`


@cache
def odd_nights(name: str) -> list[datetime]:
    """Return the hours from 1990 to 2037 in which the clocks of a time zone change."""
    zone, found = ZoneInfo(name), []
    early = datetime(1990, 1, 1, tzinfo=UTC)
    while early.year < 2037:
        late = early + 10 * DAY
        following, offset = late, early.astimezone(zone).utcoffset()
        if late.astimezone(zone).utcoffset() != offset:
            while late - early > timedelta(hours=1):
                middle = early + (late - early) / 2
                if middle.astimezone(zone).utcoffset() == offset:
                    early = middle
                else:
                    late = middle
            found.append(early.replace(minute=0, second=0, microsecond=0))
        early = following
    return found


@st.composite
def nights(draw: st.DrawFn) -> tuple[str, datetime]:
    """A time zone, and a moment, often near one at which its clocks change."""
    name = draw(ZONES)
    changes = odd_nights(name)
    if not changes or draw(st.booleans()):
        return name, draw(MOMENTS)
    return name, draw(st.sampled_from(changes)) + timedelta(minutes=draw(st.integers(-3000, 3000)))


def shown(moment: datetime, zone: ZoneInfo) -> datetime:
    return moment.astimezone(zone).replace(tzinfo=None)


@settings(max_examples=300, deadline=None)
@given(nights(), st.integers(0, 1439))
def test_a_time_is_the_first_moment_at_which_clocks_show_it_or_more(night: tuple[str, datetime], minute: int) -> None:
    name, near = night
    zone = ZoneInfo(name)
    local = datetime.combine(shown(near, zone).date(), time(minute // 60, minute % 60))
    found = moment_of(local, zone)
    assert shown(found, zone) >= local
    exists = any(shown(local.replace(tzinfo=zone, fold=fold).astimezone(UTC), zone) == local for fold in (0, 1))
    assert (shown(found, zone) == local) is exists
    # No moment of the day before shows that time or a later one, unless it is there twice.
    for minutes in range(1, 200):
        assert shown(found - minutes * MINUTE, zone) < local


@settings(max_examples=200, deadline=None)
@given(nights(), TIMES, DAYS)
def test_each_day_has_its_times_once_and_in_order(
    night: tuple[str, datetime], times: list[str], weekdays: tuple[Weekday, ...]
) -> None:
    name, near = night
    schedule = daily(name, *times, weekdays=weekdays)
    found = series(schedule, near, near + 8 * DAY)
    assert found == sorted(set(found))
    today = shown(near, ZoneInfo(name)).date()
    days: list[date] = [today + offset * DAY for offset in range(-2, 11)]
    wanted = {each for day in days for each in schedule.moments(day) if near < each <= near + 8 * DAY}
    assert set(found) == wanted
    assert found


@settings(max_examples=200, deadline=None)
@given(nights(), TIMES, DAYS, st.integers(-20_000, 20_000))
def test_the_last_time_is_the_one_before_the_next(
    night: tuple[str, datetime], times: list[str], weekdays: tuple[Weekday, ...], minutes: int
) -> None:
    name, near = night
    schedule = daily(name, *times, weekdays=weekdays)
    now = near + minutes * timedelta(seconds=7)
    last, coming = schedule.last(now, SINCE), schedule.next(now, SINCE)
    assert last is not None
    assert coming is not None
    assert last <= now < coming
    assert schedule.next(last, SINCE) == coming
    assert schedule.last(coming, SINCE) == coming


@given(st.integers(1, 10_080), st.integers(-(10**7), 10**9))
def test_every_so_many_minutes_from_when_it_was_stored(minutes: int, seconds: int) -> None:
    every, now = Every(minutes=minutes), SINCE + timedelta(seconds=seconds)
    coming, last = every.next(now, SINCE), every.last(now, SINCE)
    assert coming is not None
    assert (coming - SINCE) % (minutes * MINUTE) == timedelta(0)
    assert coming > max(now, SINCE)
    if now >= SINCE:
        assert coming - now <= minutes * MINUTE
    assert last == (coming - minutes * MINUTE if now >= SINCE + minutes * MINUTE else None)


def test_once() -> None:
    once = Once.model_validate_json('{"due_at": "2026-12-01T07:00:00+01:00"}')
    assert series(once, SINCE, SINCE + 1000 * DAY) == [utc("2026-12-01T06:00")]
    assert once.last(utc("2026-12-01T05:59"), SINCE) is None
    assert once.last(utc("2026-12-01T06:00"), SINCE) == once.due_at


@pytest.mark.parametrize("zone", ["Europe/Atlantis", "../etc/passwd", "Europe", "", "A" * 70])
def test_what_is_no_time_zone(zone: str) -> None:
    with pytest.raises(ValidationError):
        daily(zone, "02:00")
