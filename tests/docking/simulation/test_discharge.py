import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from docking.simulation.discharge import HHR650D, DischargeCurve

CURVE = DischargeCurve(HHR650D)
TAKEN = st.floats(min_value=0.0, max_value=CURVE.capacity)


@pytest.mark.parametrize(("taken", "printed"), [(0.0, 1.39), (1.3, 1.28), (6.25, 1.18)])
def test_it_goes_through_the_points_of_the_data_sheet(taken: float, printed: float) -> None:
    measured = CURVE.voltage(taken) - HHR650D.current * HHR650D.resistance
    assert measured == pytest.approx(printed, abs=0.006)


def test_it_ends_at_the_cut_off_with_a_bit_more_than_the_rated_capacity() -> None:
    assert CURVE.voltage(CURVE.capacity) == pytest.approx(HHR650D.cut_off, abs=1e-6)
    assert HHR650D.rated < CURVE.capacity < HHR650D.maximum


@given(TAKEN, TAKEN)
def test_the_voltage_falls_while_charge_is_taken(one: float, other: float) -> None:
    less, more = sorted((one, other))
    assert CURVE.voltage(less) >= CURVE.voltage(more)


@given(TAKEN)
def test_the_energy_is_what_is_under_the_curve(taken: float) -> None:
    parts = 2000
    width = (CURVE.capacity - taken) / parts
    area = math.fsum(CURVE.voltage(taken + (part + 0.5) * width) for part in range(parts)) * width * 3600.0
    assert CURVE.energy(taken) == pytest.approx(area, rel=1e-4, abs=1e-6)
