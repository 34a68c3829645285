import math

import pytest

from docking.behaviors.sidestep import AGREEMENT, Sidestep
from docking.estimation.beacon_filter import BeaconFilter, Crossing
from docking.parameters import MotionLimits, Receivers


def crossed(*degrees: float) -> Sidestep:
    """After crossings at these places: out of the light, back into it, out of it."""
    sidestep = Sidestep(BeaconFilter(Receivers()), MotionLimits(), 1, 2.0)
    for number, angle in enumerate(degrees):
        lit = number % 2 == 1
        sidestep._outwards = not lit
        sidestep._take(Crossing(lit, math.radians(angle), float(number)))
    return sidestep


def test_an_edge_lies_between_the_crossings_of_both_ways() -> None:
    sidestep = crossed(60.0, 59.0, 60.4)
    assert len(sidestep._crossings) == 3
    assert math.degrees(sidestep._edge()) == pytest.approx(0.5 * (60.2 + 59.0))


def test_across_half_a_turn_it_is_the_same() -> None:
    assert abs(math.degrees(crossed(179.5, -179.5, 179.5)._edge())) == pytest.approx(180.0, abs=0.01)


@pytest.mark.parametrize("places", [(50.0, 52.0, 54.0), (50.0, 53.0, 53.0), (50.0, 50.0, 56.0)])
def test_crossings_that_are_not_all_at_one_place_are_no_edge(places: tuple[float, float, float]) -> None:
    assert math.degrees(AGREEMENT) < 3.0
    assert len(crossed(*places)._crossings) < 3


def test_light_on_the_way_out_of_it_is_no_edge() -> None:
    sidestep = crossed(60.0)
    sidestep._outwards = True
    sidestep._take(Crossing(True, math.radians(60.5), 1.0))
    assert sidestep._crossings == []
