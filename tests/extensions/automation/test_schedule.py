"""Times of day in time zones: each is one moment, also when clocks change."""

from datetime import UTC, datetime, timedelta

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dock_gateway.extensions.automation.rule import Schedule
from dock_gateway.extensions.automation.schedule import last_due, next_due
from dock_gateway.http.times_of_day import WEEKDAYS, Weekday

MINUTE = timedelta(minutes=1)


def schedule(zone: str, *times: str, weekdays: tuple[Weekday, ...] = WEEKDAYS) -> Schedule:
    return Schedule(time_zone=zone, times=[*times], weekdays=[*weekdays])


def moments(schedule: Schedule, since: datetime, until: datetime) -> list[datetime]:
    """When the schedule is due, as seen by a look every minute."""
    found: list[datetime] = []
    now = since
    while now < until:
        due = last_due(schedule, now)
        if due is not None and now - due < MINUTE and due not in found:
            found.append(due)
        now += MINUTE
    return found


def utc(text: str) -> datetime:
    return datetime.fromisoformat(text).replace(tzinfo=UTC)


@pytest.mark.parametrize(
    ("times", "due"),
    [
        (("02:30",), ["2026-03-28T01:30", "2026-03-29T01:30", "2026-03-30T00:30"]),  # 02:30 is 03:30 that day
        (("02:30", "03:30"), ["2026-03-28T01:30", "2026-03-28T02:30", "2026-03-29T01:30", "2026-03-30T00:30"]),
    ],
)
def test_clocks_that_go_forward(times: tuple[str, ...], due: list[str]) -> None:
    found = moments(schedule("Europe/Berlin", *times), utc("2026-03-28T00:00"), utc("2026-03-30T01:00"))
    assert found == [utc(each) for each in due]


def test_clocks_that_go_back() -> None:
    found = moments(schedule("Europe/Berlin", "02:30"), utc("2026-10-24T00:00"), utc("2026-10-26T03:00"))
    assert found == [utc("2026-10-24T00:30"), utc("2026-10-25T00:30"), utc("2026-10-26T01:30")]


def test_days_are_those_of_the_time_zone() -> None:
    monday = schedule("Pacific/Auckland", "08:00", weekdays=("mon",))
    assert moments(monday, utc("2026-06-01T00:00"), utc("2026-06-09T00:00")) == [utc("2026-06-07T20:00")]
    assert next_due(monday, utc("2026-06-07T19:00")) == utc("2026-06-07T20:00")
    assert next_due(monday, utc("2026-06-03T00:00")) is None
    assert last_due(monday, utc("2026-06-07T19:00")) is None


zones = st.sampled_from(["UTC", "Europe/Berlin", "America/New_York", "Australia/Lord_Howe", "Asia/Kathmandu"])
times = st.lists(
    st.tuples(st.integers(0, 23), st.integers(0, 59)).map(lambda time: f"{time[0]:02}:{time[1]:02}"),
    min_size=1,
    max_size=3,
    unique=True,
)


@settings(max_examples=200, deadline=None)
@given(zones, times, st.integers(0, 2**31).map(lambda seconds: datetime.fromtimestamp(seconds, UTC)))
def test_any_moment_has_a_last_and_a_next_time(zone: str, times: list[str], now: datetime) -> None:
    last, coming = last_due(schedule(zone, *times), now), next_due(schedule(zone, *times), now)
    assert last is not None
    assert coming is not None
    assert last <= now < coming
    assert coming - last <= timedelta(hours=25)
