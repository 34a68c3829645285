import math
from random import Random

import pytest

from docking.core.geometry import Pose
from docking.simulation.odometry import DriftingOdometry, OdometrySettings

SEPARATION = 0.23


def make_odometry(drift: float, seed: int = 1) -> DriftingOdometry:
    return DriftingOdometry(OdometrySettings(drift), SEPARATION, Random(seed))


def test_without_drift_it_reckons_right() -> None:
    odometry = make_odometry(0.0)
    for _ in range(100):
        odometry.step(0.01, 0.01)
    assert odometry.pose == Pose(pytest.approx(1.0), 0.0, 0.0)
    quarter = math.pi / 2.0 * SEPARATION / 2.0
    odometry.step(-quarter, quarter)
    assert odometry.theta == pytest.approx(math.pi / 2.0)


def test_it_tells_forward_and_turning() -> None:
    assert make_odometry(0.0).measure(0.1, 0.3) == (pytest.approx(0.2), pytest.approx(0.2 / SEPARATION))


def test_its_drift_is_as_large_as_it_is_set_and_grows_with_the_way() -> None:
    turns = []
    for seed in range(500):
        odometry = make_odometry(0.01, seed)
        for _ in range(100):
            odometry.step(0.01, 0.01)
        half = odometry.theta
        for _ in range(100):
            odometry.step(0.01, 0.01)
        assert odometry.theta == pytest.approx(2.0 * half)
        turns.append(half)
    spread = math.sqrt(math.fsum(turn * turn for turn in turns) / len(turns))
    assert spread == pytest.approx(0.01 * math.sqrt(2.0) / SEPARATION, rel=0.1)
