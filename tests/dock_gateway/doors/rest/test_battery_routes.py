"""A span of time is divided into no more points than were asked for, and into the same ones while it moves."""

from datetime import UTC, datetime, timedelta

import pytest

from dock_gateway.core.errors import InvalidField
from dock_gateway.core.event import moment
from dock_gateway.doors.rest.battery_routes import describe, divide, short
from dock_gateway.storage.battery import Bucket, FieldTally

NOW = datetime(2026, 11, 21, 3, 32, 40, 123456, tzinfo=UTC)


@pytest.mark.parametrize("points", [2, 3, 600, 2000])
@pytest.mark.parametrize("seconds", [0.5, 1.0, 299.999, 300.0, 86_400.0])
def test_there_are_never_more_buckets_than_points(points: int, seconds: float) -> None:
    span = divide("/", NOW - timedelta(seconds=seconds), NOW, points)
    buckets = (span.until - 1) // span.step - span.since // span.step + 1
    assert points / 2 <= buckets <= points


def test_spans_of_one_length_have_the_same_buckets() -> None:
    steps = {divide("/", NOW + timedelta(seconds=s), NOW + timedelta(seconds=s + 300), 600).step for s in range(50)}
    assert len(steps) == 1


def test_a_moment_is_not_divided_any_further() -> None:
    assert divide("/", NOW - timedelta(microseconds=1), NOW, 2000).step == 1_000


@pytest.mark.parametrize("seconds", [0, 1])
def test_a_span_that_ends_before_it_begins(seconds: int) -> None:
    with pytest.raises(InvalidField, match=r"^since: expected a time before"):
        divide("/", NOW + timedelta(seconds=seconds), NOW, 600)


def test_columns_are_of_one_length() -> None:
    span = divide("/robot1", NOW - timedelta(minutes=5), NOW, 600)
    stamp = 1_795_234_054_500_000_000
    buckets = [Bucket(stamp, 1), Bucket(stamp + 10**9, 2)]
    buckets[1].tallies["current"] = FieldTally(3, 1.0, -1.0, 2.0)
    answer = describe(span, NOW - timedelta(minutes=5), NOW, buckets)
    assert (answer["robot"], answer["resolution_s"]) == ("/robot1", span.step / 1e9)
    assert answer["time"] == [moment(stamp), moment(stamp + 10**9)]
    assert answer["current"] == {"mean": [None, 0.3333333], "min": [None, -1.0], "max": [None, 2.0]}
    assert answer["voltage"] == {"mean": [None, None], "min": [None, None], "max": [None, None]}
    assert answer["power_supply_status"] == [1, 2]


def test_a_mean_has_no_more_digits_than_what_it_is_the_mean_of() -> None:
    assert short(12.340000000000002) == 12.34
    assert short(None) is None
