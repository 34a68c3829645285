"""Which values of battery states are believed: of each driver that is known, and of any other."""

import math
from typing import Any

import orjson
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sensor_msgs.msg import BatteryState

from dock_gateway.core.battery import COUNTS_TO_100, BatteryReading, infinities
from dock_gateway.robots.plausibility import HOLD, MAX_AGE, MAX_HOLD, RECENT, STAMP_GRACE, Plausibility
from dock_gateway.ros.messages.codec import codec
from dock_gateway.ros.robot_ports import FLOATS

WALL = 1_800_000_000.0
WELL = {"voltage": 12.4, "percentage": 0.5, "current": -1.5, "power_supply_status": 2}


def fields(**values: Any) -> dict[str, Any]:
    """A battery state as the gateway has it; what is not given is not measured."""
    message: BatteryState = codec(BatteryState).default()
    stamp = values.pop("stamp", 0)
    message.header.stamp.sec = int(stamp)
    for name, value in values.items():
        setattr(message, name, value)
    infinite = infinities({name: getattr(message, name) for name in FLOATS})
    return {**orjson.loads(codec(BatteryState).encode(message)), **infinite}


class Driver:
    """Sends states to a judge: the first at once, each other one `after` seconds later."""

    def __init__(self, **settings: bool) -> None:
        self.judge = Plausibility(**settings)
        self.now = 100.0

    def send(self, after: float = 0.1, **values: Any) -> BatteryReading:
        self.now += after
        return self.judge.judge(fields(**(WELL | values)), self.now, WALL + self.now)


def doubted(reading: BatteryReading) -> list[str]:
    return [doubt.field for doubt in reading.doubts]


@pytest.mark.parametrize(
    ("sent", "believed"),
    [
        (0.24, 0.24),
        (0.0, 0.0),
        (1.0, 1.0),
        (1.02, 1.0),
        (-0.0, 0.0),
        (-0.0005, 0.0),
        (math.nan, None),
    ],
)
def test_percentages_that_can_be_right(sent: float, believed: float | None) -> None:
    reading = Driver().send(percentage=sent)
    assert reading.percentage == (None if believed is None else pytest.approx(believed, abs=1e-6))
    assert reading.doubts == reading.named == ()


@pytest.mark.parametrize("sent", [12.0, 100.0, 1.03, -0.01, -1.0, 1e30, -1e30, math.inf, -math.inf, 65535.0, 255.0])
def test_percentages_that_cannot_be_right(sent: float) -> None:
    """A driver that counts to 100, MAVROS for "unknown", garbage."""
    reading = Driver().send(percentage=sent)
    assert reading.percentage is None
    assert doubted(reading) == ["percentage"]
    (named,) = reading.named
    assert f"{sent:.10g}"[:4] in named.sentence
    assert "0 to 1" in named.sentence
    assert (COUNTS_TO_100 in named.sentence) == (sent > 0 or math.isinf(sent))


@pytest.mark.parametrize(("sent", "believed"), [(12.0, 0.12), (100.0, 1.0), (102.0, 1.0), (0.5, 0.005), (0.0, 0.0)])
def test_a_driver_that_counts_to_100_by_the_setting(sent: float, believed: float) -> None:
    reading = Driver(counts_to_100=True).send(percentage=sent)
    assert (reading.percentage, reading.doubts) == (pytest.approx(believed), ())


@pytest.mark.parametrize("sent", [103.0, -1.0, -0.01, math.inf])
def test_what_even_such_a_driver_cannot_mean(sent: float) -> None:
    reading = Driver(counts_to_100=True).send(percentage=sent)
    assert (reading.percentage, doubted(reading)) == (None, ["percentage"])
    assert f"as the robot's {COUNTS_TO_100} says" in reading.named[0].sentence


@pytest.mark.parametrize(
    ("field", "sent", "named"),
    [
        ("voltage", -0.5, "voltage"),
        ("voltage", 12_400.0, "voltage"),  # mV
        ("voltage", math.inf, "voltage"),
        ("current", 1500.0, "current"),  # mA
        ("current", -math.inf, "current"),
        ("temperature", 298.15, "temperature"),  # K
        ("temperature", 327.67, "temperature"),  # MAVLink for "unknown"
        ("temperature", -273.2, "temperature"),
        ("charge", -1.0, "charge"),
        ("capacity", -0.001, "capacity"),
        ("design_capacity", 1e9, "design_capacity"),
        ("cell_voltage", [3.7, 65.535, -1.0], "cell_voltage.1"),
        ("cell_voltage", [math.nan, math.inf], "cell_voltage.1"),
        ("cell_temperature", [-300.0], "cell_temperature.0"),
        ("power_supply_status", 5, "power_supply_status"),
        ("power_supply_status", 255, "power_supply_status"),
    ],
)
def test_other_values_that_cannot_be_right(field: str, sent: Any, named: str) -> None:
    reading = Driver().send(**{field: sent})
    assert doubted(reading) == [named]
    assert [doubt.field for doubt in reading.named] == [named]
    assert reading.percentage == 0.5  # the others are believed
    assert (reading.current is None) == (field == "current")
    assert reading.power_supply == (0 if field == "power_supply_status" else 2)


@pytest.mark.parametrize(
    "state",
    [
        WELL,
        {"voltage": 0.0},
        {"voltage": 48.0, "current": 80.0, "temperature": -20.0, "charge": 0.0, "capacity": 400.0},
        {"cell_voltage": [3.7, math.nan, 0.0], "cell_temperature": [25.0]},
        {"power_supply_status": 4, "power_supply_health": 200, "power_supply_technology": 200},
        dict.fromkeys(("voltage", "current", "percentage", "temperature", "charge", "capacity"), math.nan),
    ],
)
def test_states_that_can_be_right(state: dict[str, Any]) -> None:
    assert Driver().send(**state).doubts == ()


def test_a_driver_that_has_not_measured_yet_is_unknown_and_named_only_if_it_stays_so() -> None:
    driver = Driver()
    zeros = {"voltage": 0.0, "percentage": 0.0, "current": 0.0, "power_supply_status": 0}
    first = driver.send(**zeros)
    assert (first.percentage, doubted(first), first.named) == (None, ["percentage"], ())
    for _ in range(9):
        assert driver.send(1.0, **zeros).named == ()
    assert [doubt.field for doubt in driver.send(1.1, **zeros).named] == ["percentage"]
    assert driver.send(percentage=0.4).percentage is None
    assert driver.send(HOLD, percentage=0.4) == BatteryReading(2, pytest.approx(0.4), pytest.approx(-1.5))
    assert driver.send(percentage=0.0, voltage=9.1).percentage == 0.0  # it is empty


def test_two_publishers_that_take_turns_are_one_doubt() -> None:
    driver = Driver()
    first = driver.send(percentage=12.0)
    for number in range(200):
        reading = driver.send(1.0, percentage=50.0 - number / 10 if number % 2 else 0.9)
        assert reading.percentage is None
        assert reading.named == first.named  # as it was first: the alert's text stays the same
    assert reading.doubts != first.doubts


def test_a_value_that_is_wrong_again_and_again_is_held_longer_each_time() -> None:
    driver = Driver()
    holds = []
    for _ in range(8):
        driver.send(percentage=-1.0)
        waited = 0
        while driver.send(1.0).percentage is None:
            waited += 1
        holds.append(waited + 1)
    assert holds == [10, 20, 40, 80, 160, 300, 300, 300]
    driver.send(RECENT, percentage=-1.0)
    driver.send(HOLD - 0.1)
    assert driver.send(0.2).percentage == 0.5
    assert MAX_HOLD == 300


def test_a_driver_that_counts_to_100_is_not_full_when_its_battery_is_empty() -> None:
    driver = Driver()
    for percentage in (24.0, 6.0, 2.5, 1.5, 1.0, 0.8):
        assert driver.send(60.0, percentage=percentage).percentage is None
    driver.send(percentage=24.0)
    assert driver.send(percentage=0.24).percentage is None
    assert driver.send(HOLD + 0.1, percentage=0.25).percentage == pytest.approx(0.25)  # it has been corrected


@pytest.mark.parametrize("before", [(12.0,), (60.0,), (3.0, 0.0), (2.5, 1.5, 0.1), (30.0, -1.0)])
def test_nor_after_it_was_out_of_reach(before: tuple[float, ...]) -> None:
    driver = Driver()
    for percentage in before:
        driver.send(percentage=percentage)
    for _ in range(3):
        assert driver.send(MAX_HOLD + 0.1, percentage=1.0).percentage is None


def test_more_than_full_for_a_moment() -> None:
    driver = Driver()
    assert driver.send(percentage=1.05).percentage is None
    assert driver.send(HOLD + 0.1, percentage=1.0).percentage == 1.0


def test_the_sign_of_a_charging_current() -> None:
    assert Driver().send(current=1.1).current == pytest.approx(1.1)
    assert Driver(charges_negative=True).send(current=-1.1).current == pytest.approx(1.1)


# ---------------------------------------------------------------------- stamps


def test_stamps_near_the_clock_and_none() -> None:
    driver = Driver()
    for offset in (0.0, -MAX_AGE + 1, MAX_AGE - 2):
        assert driver.send(stamp=WALL + driver.now + offset).doubts == ()
    assert driver.send(stamp=0).doubts == ()


@pytest.mark.parametrize("stamp", [1.0, WALL - 3600, WALL + 3600, 2**31 - 1])
def test_an_old_measurement_that_is_sent_again_is_not_believed(stamp: float) -> None:
    driver = Driver()
    for _ in range(60):
        reading = driver.send(1.0, stamp=stamp, percentage=0.1, power_supply_status=1)
        assert (reading.power_supply, reading.percentage, reading.current) == (0, None, None)
        assert doubted(reading) == ["header.stamp"]
        assert bool(reading.named) == (driver.now >= 101.0 + STAMP_GRACE)
    assert "not believed at all" in reading.named[0].sentence
    assert driver.send(stamp=WALL + driver.now).percentage == 0.5


def test_a_measurement_that_is_sent_again_until_it_is_old() -> None:
    driver = Driver()
    stamp = WALL + driver.now
    for _ in range(int(MAX_AGE)):
        assert driver.send(1.0, stamp=stamp).percentage == 0.5
    assert driver.send(2.0, stamp=stamp).percentage is None


@pytest.mark.parametrize("offset", [-3600.0, 7200.0])
def test_a_robot_whose_clock_is_off_is_believed_and_named(offset: float) -> None:
    driver = Driver()
    assert driver.send(stamp=WALL + driver.now + offset).percentage is None  # it may be an old one
    for _ in range(20):
        reading = driver.send(1.0, stamp=WALL + driver.now + 1.0 + offset)
        assert (reading.percentage, doubted(reading)) == (0.5, ["header.stamp"])
    (named,) = reading.named
    assert "set the clock" in named.sentence
    assert f"{abs(offset):.0f} s {'behind' if offset < 0 else 'ahead of'} the gateway's clock" in named.sentence


@pytest.mark.parametrize("factor", [1.0, 0.3, 5.0])
def test_a_simulation_that_counts_from_zero_is_believed(factor: float) -> None:
    driver = Driver()
    driver.send(stamp=10)
    for number in range(1, 30):
        reading = driver.send(1.0, stamp=10 + math.ceil(number * factor))
        assert (reading.percentage, reading.doubts, reading.named) == (0.5, (), ())


# ---------------------------------------------------------------------- whatever is sent

FLOAT = st.floats(width=32) | st.sampled_from([0.0, -0.01, 1.02, 12.0, math.nan, math.inf, -math.inf])
STATE = st.fixed_dictionaries(
    {
        "voltage": FLOAT,
        "percentage": FLOAT,
        "current": FLOAT,
        "temperature": FLOAT,
        "cell_voltage": st.lists(FLOAT, max_size=3),
        "power_supply_status": st.integers(0, 255),
        "stamp": st.integers(-(2**31), 2**31 - 1),
    }
)


@given(states=st.lists(STATE, max_size=8), to_100=st.booleans(), after=st.floats(0.0, 20.0))
def test_what_is_believed_is_always_in_range_and_json(states: list[dict[str, Any]], to_100: bool, after: float) -> None:
    driver = Driver(counts_to_100=to_100)
    for state in states:
        reading = driver.send(after, **state)
        assert reading.percentage is None or 0.0 <= reading.percentage <= 1.0
        assert reading.current is None or abs(reading.current) <= 1000.0
        assert reading.power_supply in range(5)
        document = [doubt.document() for doubt in reading.doubts]
        assert orjson.loads(orjson.dumps(document)) == document
        assert {doubt.field for doubt in reading.named} <= {doubt.field for doubt in reading.doubts} | {
            doubt.field for doubt in reading.named if doubt.field.startswith("cell_")
        }
        percentage = state["percentage"]
        if not math.isnan(percentage) and (percentage < -0.001 or percentage / (100 if to_100 else 1) > 1.0200001):
            assert reading.percentage is None
