import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from docking.core.battery import BATTERY_TYPE, Battery, BatteryReading, describe_absence, describe_status

SECONDS = st.floats(min_value=0.0, max_value=1e9)


@pytest.mark.parametrize(
    ("status", "connected"), [(0, False), (1, True), (2, False), (3, False), (4, True), (255, False)]
)
def test_only_charging_and_full_are_connected(status: int, connected: bool) -> None:
    assert BatteryReading(status, 0.0).connected is connected


@given(SECONDS, SECONDS)
def test_the_age_is_negative_ahead_of_the_clock(received: float, now: float) -> None:
    assert BatteryReading(1, received).age(now) == now - received


def test_the_battery_keeps_the_latest_reading() -> None:
    battery = Battery()
    assert battery.latest is None
    battery.update(BatteryReading(3, 1.0))
    battery.update(BatteryReading(1, 2.0, "the message"))
    assert battery.latest == BatteryReading(1, 2.0, "the message")


def test_a_connected_charger_is_told_at_once() -> None:
    battery = Battery()
    told: list[BatteryReading | None] = []
    battery.on_connected = lambda: told.append(battery.latest)
    for status in (3, 1, 2, 4):
        battery.update(BatteryReading(status, 1.0))
    assert told == [BatteryReading(1, 1.0), BatteryReading(4, 1.0)]


def test_a_status_is_described_with_its_name_if_it_has_one() -> None:
    assert describe_status(3) == "3 (NOT_CHARGING)"
    assert describe_status(200) == "200 (no known status)"


@pytest.mark.parametrize("percentage", [0.0, 0.24, 1.0, math.nan])
def test_a_percentage_from_0_to_1_or_none_is_right(percentage: float) -> None:
    assert BatteryReading(3, 0.0, percentage=percentage).fault is None


@pytest.mark.parametrize("percentage", [24.0, -0.1, 1.01, math.inf])
def test_any_other_percentage_is_not(percentage: float) -> None:
    fault = BatteryReading(3, 0.0, percentage=percentage).fault
    assert fault == f"has a percentage of {percentage:g}, but it must be from 0 to 1"


@pytest.mark.parametrize(
    ("current", "believed"),
    [(1.5, 1.5), (-80.0, -80.0), (math.nan, None), (1100.0, None), (-math.inf, None), (math.inf, None), (1e30, None)],
)
def test_a_current_that_cannot_be_right_is_as_if_not_measured(current: float, believed: float | None) -> None:
    reading = BatteryReading(3, 0.0, current=current)
    assert reading.believed_current == believed if believed is not None else math.isnan(reading.believed_current)
    named = believed is None and not math.isnan(current)
    assert reading.fault == (f"has a current of {current:g} A, but one above 1000 A is not believed" if named else None)


def test_an_unknown_status_is_named_with_all_else() -> None:
    fault = BatteryReading(9, 0.0, percentage=12.0).fault
    assert fault == (
        "has a percentage of 12, but it must be from 0 to 1, and has the power_supply_status 9 (no known status)"
    )


def test_what_there_is_instead_of_a_battery() -> None:
    assert describe_absence("/battery_status", [], []) == "nothing comes on /battery_status"
    assert describe_absence("/battery_status", [BATTERY_TYPE], ["/b", "/a"]) == (
        "nothing comes on /battery_status, but batteries are on /a, /b: remap battery_status to the robot's"
    )
    assert describe_absence("/b", ["px4_msgs/msg/BatteryStatus"], []) == (
        f"/b is px4_msgs/msg/BatteryStatus, not {BATTERY_TYPE}"
    )
    assert "/t4 and 2 more: remap" in describe_absence("/b", [], [f"/t{number}" for number in range(7)])
