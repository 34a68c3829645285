import math
from itertools import pairwise
from random import Random

import pytest

from docking.core.geometry import Pose
from docking.core.observation import Velocity
from docking.simulation.faults import Fault
from docking.simulation.odometry import DriftingOdometry, OdometrySettings
from docking.simulation.settings import Settings
from docking.simulation.simulation import Simulation

SEPARATION = 0.23
GOOD = OdometrySettings()


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


def readings(settings: OdometrySettings, *, faulty: bool = False) -> list[tuple[float, Pose]]:
    """What arrives while a robot drives, 10 times a second: stamps and poses."""
    simulation = Simulation(Settings(odometry=settings))
    simulation.set_fault(Fault.REPEATED_ODOMETRY, faulty)
    arrived = []
    for _ in range(100):
        simulation.run(0.1, Velocity(0.2))
        assert simulation.reading is not None
        assert simulation.reading[1].stamp == pytest.approx(simulation.time)
        arrived.append((simulation.reading[0], simulation.reading[1].pose))
    return arrived


def test_odometry_can_repeat_its_last_message_with_new_stamps() -> None:
    for arrived in (readings(OdometrySettings(repeat_every=3.0, repeat_for=0.5)), readings(GOOD, faulty=True)):
        repeated = [at for (at, pose), (_, before) in pairwise(reversed(arrived)) if pose == before]
        assert len({at for at, _ in arrived}) == 100, "the stamps are new"
        assert len(repeated) == pytest.approx(15, abs=3)
        assert all(at % 3.0 < 0.6 for at in repeated)


def test_repeated_messages_can_have_the_stamp_of_the_first() -> None:
    arrived = readings(OdometrySettings(repeat_every=3.0, repeat_for=0.5, repeat_stamps=True))
    assert len({at for at, _ in arrived}) == pytest.approx(85, abs=3)


def test_the_clock_of_its_stamps_can_be_ahead() -> None:
    assert readings(OdometrySettings(stamp_offset=5.0))[9][0] == pytest.approx(6.0)
