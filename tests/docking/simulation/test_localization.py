import math

import pytest

from docking.core.geometry import Pose
from docking.simulation.dock import DOCKED
from docking.simulation.faults import Fault
from docking.simulation.localization import LocalizationSettings
from docking.simulation.settings import Settings
from docking.simulation.simulation import Simulation


def _off(simulation: Simulation) -> Pose:
    """The docked pose by the localization, as seen from where it is."""
    return simulation.odometry_origin.compose(simulation.located_docked).relative_to(DOCKED)


def test_without_an_error_the_dock_is_where_it_is() -> None:
    simulation = Simulation()
    simulation.run(1.0)
    assert _off(simulation).distance_to(Pose()) < 1e-9
    assert simulation.located_origin.distance_to(simulation.odometry_origin) < 1e-9


def test_an_error_shows_at_the_dock_and_in_the_map() -> None:
    settings = LocalizationSettings(error_x=0.05, error_y=-0.02, error_yaw=0.1)
    simulation = Simulation(Settings(localization=settings))
    simulation.run(1.0)
    off = _off(simulation)
    assert (off.x, off.y, off.theta) == pytest.approx((0.05, -0.02, 0.1))
    on_map = simulation.located_origin.compose(simulation.located_docked)
    assert on_map.distance_to(DOCKED) < 1e-9, "by the map the dock is where the map has it"


def test_jumps_come_and_go_and_keep_their_lengths() -> None:
    simulation = Simulation()
    simulation.set_fault(Fault.LOCALIZATION_JUMPS, True)
    ways = []
    for _ in range(600):
        simulation.run(0.1)
        ways.append(math.hypot(_off(simulation).x, _off(simulation).y))
    away = [way for way in ways if way > 1e-9]
    assert 0.05 - 1e-9 <= min(away) <= max(away) <= 0.2 + 1e-9
    assert 60 < len(away) < 300
    assert len({round(way, 6) for way in away}) > 5
    simulation.set_fault(Fault.LOCALIZATION_JUMPS, False)
    simulation.run(3.0)
    assert _off(simulation).distance_to(Pose()) < 1e-9
