import math
from dataclasses import replace
from random import Random
from statistics import fmean, pstdev

import pytest
from hypothesis import given
from hypothesis import strategies as st

from docking.core.geometry import Pose
from docking.simulation.infrared import InfraredReceivers, InfraredSettings

SURE = InfraredSettings(noise=0.0)


def measure(robot: Pose, settings: InfraredSettings = SURE) -> tuple[float, float, float]:
    return InfraredReceivers(settings, Random(1), Random(2)).measure(robot)


def turned(degrees: float) -> Pose:
    """A robot whose receivers are 1 m in front of the beacon, turned this much to the left."""
    theta = math.radians(degrees)
    return Pose(-1.0 - 0.15 * math.cos(theta), -0.15 * math.sin(theta), theta)


@pytest.mark.parametrize(
    ("robot", "seen"),
    [
        (turned(0.0), (False, True, False)),
        (turned(-10.0), (True, True, False)),
        (turned(-20.0), (True, False, False)),
        (turned(-34.0), (True, False, False)),
        (turned(-35.0), (False, False, False)),
        (turned(10.0), (False, True, True)),
        (turned(20.0), (False, False, True)),
        (turned(180.0), (False, False, False)),
        (Pose(-2.14, 0.0, 0.0), (False, True, False)),
        (Pose(-2.16, 0.0, 0.0), (False, False, False)),
    ],
)
def test_the_beacon_is_seen_by_those_that_look_at_it(robot: Pose, seen: tuple[bool, bool, bool]) -> None:
    """A robot that is turned to the right has the beacon on its left."""
    distances = measure(robot)
    assert tuple(math.isfinite(distance) for distance in distances) == seen


def test_it_shines_to_the_front_only() -> None:
    behind = Pose(0.8, 0.0, math.pi)
    beside = Pose(0.0, -1.0, math.pi / 2.0)
    assert measure(behind) == measure(beside) == (math.inf, math.inf, math.inf)


def test_the_distance_is_from_the_receiver_to_the_beacon() -> None:
    assert measure(Pose(-1.0, 0.0, 0.0))[1] == pytest.approx(0.85)


def test_a_docked_robot_still_sees_it() -> None:
    assert measure(Pose(-0.2, 0.0, 0.0))[1] == pytest.approx(0.05)


def test_its_noise_is_as_large_as_it_is_set() -> None:
    receivers = InfraredReceivers(replace(SURE, noise=0.02), Random(1), Random(2))
    distances = [receivers.measure(Pose(-1.0, 0.0, 0.0))[1] for _ in range(4000)]
    assert fmean(distances) == pytest.approx(0.85, abs=0.002)
    assert pstdev(distances) == pytest.approx(0.02, rel=0.05)


@given(st.floats(-3.0, 0.5), st.floats(-2.0, 2.0), st.floats(-4.0, 4.0), st.floats(0.0, 1.0))
def test_a_distance_is_in_range_or_infinite(x: float, y: float, theta: float, noise: float) -> None:
    for distance in measure(Pose(x, y, theta), replace(SURE, noise=noise)):
        assert distance == math.inf or SURE.minimum <= distance <= SURE.range


def test_ghosts_are_anything_whether_the_beacon_is_seen_or_not() -> None:
    receivers = InfraredReceivers(replace(SURE, ghosts=0.1), Random(1), Random(2))
    away = [receivers.measure(Pose(-1.0, 0.0, math.pi)) for _ in range(2000)]
    ghosts = [distance for ranges in away for distance in ranges if distance < math.inf]
    assert len(ghosts) == pytest.approx(600, rel=0.15)
    assert fmean(ghosts) == pytest.approx(1.0, abs=0.1)
    seen = [receivers.measure(Pose(-1.0, 0.0, 0.0))[1] for _ in range(2000)]
    assert sum(distance != pytest.approx(0.85) for distance in seen) == pytest.approx(200, rel=0.25)


def test_something_hides_the_beacon_now_and_then() -> None:
    receivers = InfraredReceivers(replace(SURE, hidden_every=10.0, hidden_for=0.5), Random(1), Random(2))
    dark = [0.01 * n for n in range(3000) if receivers.measure(Pose(-1.0, 0.0, 0.0), 0.01 * n)[1] == math.inf]
    assert len(dark) == pytest.approx(150, abs=3)
    assert dark[-1] - dark[0] > 15.0


def test_hidden_it_is_not_seen_by_any() -> None:
    receivers = InfraredReceivers(SURE, Random(1), Random(2))
    assert receivers.measure(Pose(-1.0, 0.0, 0.0), hidden=True) == (math.inf, math.inf, math.inf)
