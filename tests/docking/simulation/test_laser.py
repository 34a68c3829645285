"""The laser scanner against geometry."""

import math

import numpy as np
import pytest

from docking.core.geometry import Pose
from docking.simulation.dock import Dock, DockSettings
from docking.simulation.laser import LaserScanner, LaserSettings
from docking.simulation.obstacle import Obstacle
from docking.simulation.settings import Settings
from docking.simulation.simulation import Simulation

AHEAD = 180
"""The ray along the scanner's x axis."""


def scan(robot: Pose, *obstacles: Obstacle, **settings: float) -> list[float]:
    scanner = LaserScanner(LaserSettings(noise=0.0, **settings), 1)
    return list(scanner.scan(robot, Dock(DockSettings()), obstacles))


def test_it_measures_the_dock_and_an_obstacle() -> None:
    distances = scan(Pose(-1.0, 0.0, 0.0), Obstacle(-1.0, 1.0, 0.2), Obstacle(-2.0, 0.0, 0.1))
    assert distances[AHEAD] == pytest.approx(0.96)
    assert distances[AHEAD + 90] == pytest.approx(0.8)
    assert distances[0] == pytest.approx(0.9)
    assert distances[AHEAD - 90] == math.inf


def test_the_mount_counts_and_the_range() -> None:
    assert scan(Pose(-1.0, 0.0, 0.0), x=0.1, yaw=math.pi / 2)[AHEAD - 90] == pytest.approx(0.86)
    assert scan(Pose(-1.0, 0.0, 0.0), range=0.9)[AHEAD] == math.inf


def test_each_point_of_a_scan_is_on_something_solid() -> None:
    robot = Simulation(Settings(start=Pose(-0.8, 0.3, 0.4), laser=LaserSettings(noise=0.0, x=0.1, y=0.05, yaw=1.0)))
    robot.scanning = True
    robot.run(0.2)
    seen = robot.observe().scan
    assert seen is not None
    assert len(seen.points) > 20
    start = Pose(-0.8, 0.3, 0.4)  # odometry begins there
    for x, y in seen.points:
        point = start.compose(Pose(x, y))
        assert robot.dock.clearance(point.x, point.y) < 1e-6


def test_it_does_not_run_unless_it_is_wanted_and_is_noisy() -> None:
    robot = Simulation(Settings())
    robot.run(1.0)
    assert robot.observe().scan is None
    robot.scanning = True
    robot.run(5.0)
    assert robot.scan is not None
    seen = robot.scan.distances[np.isfinite(robot.scan.distances)]
    assert 0 < len(seen) < 360
