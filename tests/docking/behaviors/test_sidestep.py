"""Where the beacon's light ends: crossings that agree are an edge, others are not."""

import math

import pytest

from docking.behaviors.sidestep import Sidestep
from docking.core.geometry import Pose
from docking.core.observation import STANDSTILL, Observation, Odometry, Velocity
from docking.estimation.beacon_filter import Crossing
from docking.goal.behavior import Done, Failed, Step
from docking.parameters import MotionLimits, Receivers


class Beacon:
    """What a sidestep needs of a filter: straight ahead of the receivers, nearly, and lit at first."""

    receivers = Receivers()
    known = True

    def __init__(self) -> None:
        self.lit = True
        self.metres = 1.0
        self.angle = 0.0
        self.heard_at = self.seen_at = 0.0
        self.crossings: list[Crossing] = []
        self.edges: list[float] = []

    def bearing(self, robot: Pose) -> float:
        return 0.4

    def distance(self, robot: Pose) -> float:
        return self.metres

    def confirm_edge(self, side: int, line_of_sight: float) -> None:
        self.edges.append(math.degrees(line_of_sight))


class Drive:
    """A robot that looks for the right edge; where its light ends and begins again, the test says, in degrees."""

    def __init__(self) -> None:
        self.beacon = Beacon()
        self._sidestep = Sidestep(self.beacon, MotionLimits(), 1, 2.0)  # type: ignore[arg-type] # see Beacon
        self._now = 0.0

    def step(self) -> Step:
        self._now += 1.0
        self.beacon.heard_at = self.beacon.seen_at = self._now
        return self._sidestep.step(Observation(self._now, odometry=Odometry(Pose(), STANDSTILL, self._now)), 0.05)

    def cross(self, angle: float, *, lit: bool, beyond: float = 3.0) -> Step:
        """Cross an edge, and drive on until it is certain that it was crossed."""
        self.beacon.lit = lit
        self.beacon.crossings.append(Crossing(lit, math.radians(angle), self._now + 0.5))
        self.beacon.angle = math.radians(angle - beyond if lit else angle + beyond)
        return self.step()

    def to_and_fro(self, *angles: float) -> list[Step]:
        """Out of the light, back into it, out of it, and so on."""
        return [self.cross(angle, lit=number % 2 == 1) for number, angle in enumerate(angles)]


def test_an_edge_lies_between_the_crossings_of_both_ways() -> None:
    drive = Drive()
    assert [step == Done() for step in drive.to_and_fro(60.0, 59.0, 60.4)] == [False, False, True]
    assert drive.beacon.edges == [pytest.approx(0.5 * (60.2 + 59.0))]


def test_across_half_a_turn_it_is_the_same() -> None:
    drive = Drive()
    drive.to_and_fro(179.5, -179.5, 179.5)
    assert abs(drive.beacon.edges[0]) == pytest.approx(180.0, abs=0.01)


def test_crossings_to_and_fro_may_lie_apart_as_with_late_odometry() -> None:
    assert Drive().to_and_fro(60.0, 64.0, 60.0)[-1] == Done()


@pytest.mark.parametrize("places", [(50.0, 52.0, 54.0), (50.0, 56.0, 56.0), (50.0, 50.0, 53.0)])
def test_crossings_that_are_not_all_at_one_place_are_no_edge(places: tuple[float, float, float]) -> None:
    assert Done() not in Drive().to_and_fro(*places)


def test_light_on_the_way_out_of_it_is_no_edge() -> None:
    drive = Drive()
    drive.cross(60.0, lit=False, beyond=1.0)
    drive.cross(60.5, lit=True)
    assert [step == Done() for step in drive.to_and_fro(60.0, 59.0, 60.4)] == [False, False, True]


def test_it_never_drives_up_to_the_dock_in_search_of_an_edge() -> None:
    drive = Drive()
    assert isinstance(drive.step(), Velocity)
    drive.beacon.metres = 0.46
    step = drive.cross(0.0, lit=False, beyond=0.0)
    assert isinstance(step, Velocity)
    assert step.linear_x > 0.0
    drive.beacon.metres = 0.25
    assert isinstance(drive.step(), Failed)
