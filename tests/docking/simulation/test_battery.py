import math
from dataclasses import fields
from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from docking.core.battery import PowerSupplyStatus
from docking.simulation.battery import BatteryPack, BatterySettings

DRIVING = 6.0
RUNS = st.lists(
    st.tuples(st.floats(1.0, 400.0), st.floats(0.0, 60.0), st.booleans(), st.booleans()), min_size=1, max_size=12
)


def make_battery(start: float = 0.24, **more: float) -> BatteryPack:
    return BatteryPack(BatterySettings(battery_start=start, **more), Random(1))


def run(battery: BatteryPack, seconds: float, power: float = DRIVING, **charger: bool) -> None:
    for _ in range(round(seconds)):
        battery.step(1.0, power, connected=charger.get("connected", False), powered=charger.get("powered", True))


def test_it_is_the_tutorials_battery_of_nine_volts_a_quarter_full() -> None:
    measured = make_battery().measure()
    assert measured.percentage == pytest.approx(0.24)
    assert measured.charge == pytest.approx(0.24 * measured.capacity)
    assert 8.0 < measured.voltage < 9.5


@pytest.mark.parametrize(
    ("connected", "powered", "status"),
    [
        (False, True, PowerSupplyStatus.DISCHARGING),
        (False, False, PowerSupplyStatus.DISCHARGING),
        (True, False, PowerSupplyStatus.NOT_CHARGING),
        (True, True, PowerSupplyStatus.CHARGING),
    ],
)
def test_the_status_and_the_sign_of_the_current_tell_the_same(
    connected: bool, powered: bool, status: PowerSupplyStatus
) -> None:
    battery = make_battery()
    before = battery.percentage
    run(battery, 10.0, connected=connected, powered=powered)
    charging = status is PowerSupplyStatus.CHARGING
    assert battery.status is status
    assert (battery.current > 0.0) is charging
    assert (battery.percentage > before) is charging


def test_the_voltage_sinks_under_load_and_rises_on_the_charger() -> None:
    battery = make_battery()
    run(battery, 1.0, power=0.0)
    idle = battery.voltage
    run(battery, 1.0, power=30.0)
    assert battery.voltage < idle
    run(battery, 1.0, connected=True)
    assert battery.voltage > idle


def test_the_poles_give_the_power_that_is_asked_for() -> None:
    battery = make_battery(0.6)
    run(battery, 1.0, power=12.0)
    assert -battery.current * battery.voltage == pytest.approx(12.0, rel=1e-3)


def test_it_is_full_at_the_top_and_stays_so_while_it_is_connected() -> None:
    battery = make_battery(0.999)
    run(battery, 120.0, connected=True)
    measured = battery.measure()
    assert (measured.status, measured.current, measured.percentage) == (PowerSupplyStatus.FULL, 0.0, 1.0)
    run(battery, 60.0, connected=True)
    assert battery.status is PowerSupplyStatus.FULL
    run(battery, 1.0)
    assert battery.status is PowerSupplyStatus.DISCHARGING


def test_an_empty_one_takes_about_an_hour_to_charge() -> None:
    battery = make_battery(0.0)
    seconds = 0
    while battery.status is not PowerSupplyStatus.FULL:
        run(battery, 1.0, connected=True)
        seconds += 1
    assert seconds == pytest.approx(3600.0, rel=0.05)
    assert 26.0 < battery.temperature < 45.0, "it warms up"


def test_an_empty_one_gives_nothing_more_and_can_be_charged() -> None:
    battery = make_battery(0.001)
    run(battery, 600.0, power=30.0)
    assert battery.empty
    assert (battery.percentage, battery.current) == (0.0, 0.0)
    run(battery, 10.0, connected=True)
    assert not battery.empty
    assert battery.percentage > 0.0


@pytest.mark.parametrize("status", [False, True])
def test_the_cells_make_up_the_voltage(status: bool) -> None:
    battery = make_battery()
    run(battery, 5.0, connected=status)
    measured = battery.measure()
    assert math.fsum(measured.cell_voltages) == pytest.approx(measured.voltage)
    assert len(set(measured.cell_voltages)) == len(measured.cell_voltages) == len(measured.cell_temperatures) == 7


@settings(max_examples=40)
@given(st.floats(0.0, 1.0), RUNS)
def test_energy_is_neither_made_nor_lost(start: float, runs: list[tuple[float, float, bool, bool]]) -> None:
    """What the poles give and what the resistance heats is what is gone, by voltage and current as they are told."""
    battery = make_battery(start)
    before, given_away, moved = battery.energy, 0.0, 0.0
    for seconds, power, connected, powered in runs:
        for _ in range(round(seconds)):
            # The voltage of the middle of the step: its error is of the second order.
            first = battery.voltage - battery.current * 7 * 0.0046
            battery.step(1.0, power, connected=connected, powered=powered)
            last = battery.voltage - battery.current * 7 * 0.0046
            given_away -= (0.5 * (first + last) + battery.current * 7 * 0.0046) * battery.current
            moved += abs(battery.current) * 9.0
    assert battery.energy + given_away + battery.heat == pytest.approx(before, abs=1e-3 * moved + 1e-6)


@settings(max_examples=60)
@given(st.floats(0.0, 1.0), RUNS)
def test_whatever_happens_the_numbers_are_numbers_and_in_range(
    start: float, runs: list[tuple[float, float, bool, bool]]
) -> None:
    battery = make_battery(start)
    for seconds, power, connected, powered in runs:
        run(battery, seconds, power, connected=connected, powered=powered)
        measured = battery.measure()
        for field in fields(measured):
            value = getattr(measured, field.name)
            assert all(math.isfinite(number) for number in (value if isinstance(value, tuple) else (value,)))
        assert 0.0 <= measured.percentage <= 1.0
        assert 6.5 < measured.voltage < 10.5
        assert 25.0 <= measured.temperature < 60.0
        assert measured.current >= 0.0 if connected and powered else measured.current <= 0.0
