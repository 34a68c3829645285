import math

import pytest

from docking.behaviors.sidestep import CROSSINGS, Sidestep
from docking.core.geometry import Pose
from docking.core.observation import STANDSTILL, Observation, Odometry, Velocity
from docking.estimation.beacon_filter import BeaconFilter, Crossing
from docking.goal.behavior import Failed
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


def test_crossings_to_and_fro_may_lie_apart_as_with_late_odometry() -> None:
    assert len(crossed(60.0, 64.0, 60.0)._crossings) == CROSSINGS


@pytest.mark.parametrize("places", [(50.0, 52.0, 54.0), (50.0, 56.0, 56.0), (50.0, 50.0, 53.0)])
def test_crossings_that_are_not_all_at_one_place_are_no_edge(places: tuple[float, float, float]) -> None:
    assert len(crossed(*places)._crossings) < CROSSINGS


def test_light_on_the_way_out_of_it_is_no_edge() -> None:
    sidestep = crossed(60.0)
    sidestep._outwards = True
    sidestep._take(Crossing(True, math.radians(60.5), 1.0))
    assert sidestep._crossings == []


class BeaconAhead:
    """Straight ahead of the receivers, lit, and ever nearer."""

    receivers = Receivers()
    known = lit = True
    crossings: tuple[Crossing, ...] = ()
    heard_at = 0.0

    def __init__(self) -> None:
        self.metres = 1.0

    def bearing(self, robot: Pose) -> float:
        return 0.4

    def distance(self, robot: Pose) -> float:
        return self.metres


def test_it_never_drives_up_to_the_dock_in_search_of_an_edge() -> None:
    beacon = BeaconAhead()
    sidestep = Sidestep(beacon, MotionLimits(), 1, 2.0)  # type: ignore[arg-type] # all that it needs of a filter
    observation = Observation(0.0, odometry=Odometry(Pose(), STANDSTILL, 0.0))
    assert isinstance(sidestep.step(observation, 0.05), Velocity)
    sidestep._forwards, sidestep._turning, sidestep._crossings = True, False, [Crossing(False, 0.0, 0.0)]
    sidestep._choose_way = lambda: None  # type: ignore[method-assign] # to and fro over an edge
    beacon.metres = 0.46
    step = sidestep.step(observation, 0.05)
    assert isinstance(step, Velocity)
    assert step.linear_x > 0.0
    beacon.metres = 0.25
    assert isinstance(sidestep.step(observation, 0.05), Failed)
