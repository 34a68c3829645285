"""The room: what the scanner sees, what the robot runs into and what the map shows are the same."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from docking.core.geometry import Pose
from docking.core.observation import Velocity
from docking.simulation.box import Box
from docking.simulation.dock import DOCKED, Dock, DockSettings
from docking.simulation.faults import Fault
from docking.simulation.laser import ANGLE_MIN, LaserScanner, LaserSettings
from docking.simulation.occupancy import CELL, map_of
from docking.simulation.room import WORKSHOP, Room
from docking.simulation.settings import Settings
from docking.simulation.simulation import Simulation

DOCK = Dock(DockSettings())
GRID = map_of(WORKSHOP, DOCK)
FLOOR = WORKSHOP.floor
IN_ROOM = Settings(room=WORKSHOP)
POSES = st.builds(Pose, st.floats(-12.0, 3.0), st.floats(-6.0, 7.0), st.floats(-math.pi, math.pi))


def clearance(room: Room, x: float, y: float) -> float:
    """From a point to the nearest wall, piece of furniture, or the dock, in m; below 0 behind a wall."""
    floor = room.floor
    walls = min(x - floor.x_min, floor.x_max - x, y - floor.y_min, floor.y_max - y)
    return min(walls, *(box.clearance(x, y) for box in (*room.furniture, *DOCK.boxes)))


@settings(max_examples=100)
@given(POSES, st.lists(st.tuples(st.floats(-1.0, 1.0), st.floats(-1.5, 1.5)), max_size=5))
def test_the_robot_is_never_inside_something_solid(place: Pose, drive: list[tuple[float, float]]) -> None:
    simulation = Simulation(replace(IN_ROOM, start=place))
    robot = simulation.robot
    assert clearance(WORKSHOP, robot.x, robot.y) >= robot.radius - 1e-6
    for linear, angular in drive:
        simulation.run(0.4, Velocity(linear, angular))
        assert clearance(WORKSHOP, robot.x, robot.y) >= robot.radius - 1e-6


@settings(max_examples=30)
@given(POSES)
def test_no_ray_of_a_scan_ends_behind_a_wall(place: Pose) -> None:
    robot = Simulation(replace(IN_ROOM, start=place)).robot.pose
    scanner = LaserScanner(LaserSettings(noise=0.0, range=50.0), 1)
    distances = scanner.scan(robot, DOCK, (), WORKSHOP)
    assert np.isfinite(distances).all(), "there is a wall at the end of each"
    for ray in range(0, len(distances), 17):
        distance, angle = distances[ray], robot.theta + ANGLE_MIN + ray * scanner.settings.angle_increment

        def along(way: float, angle: float = angle) -> tuple[float, float]:
            return robot.x + way * math.cos(angle), robot.y + way * math.sin(angle)

        assert all(clearance(WORKSHOP, *along(way)) > 0.0 for way in np.arange(0.0, distance - 1e-6, 0.04))
        assert clearance(WORKSHOP, *along(distance)) == pytest.approx(0.0, abs=1e-6)
        row, column = GRID.cell(*along(distance))
        assert GRID.occupied[row - 1 : row + 2, column - 1 : column + 2].any(), "the map shows it"


EDGES = st.floats(-1.2, 1.2)


@settings(max_examples=25)
@given(st.lists(st.tuples(EDGES, EDGES, EDGES, EDGES), max_size=4))
def test_cells_are_occupied_where_something_is_and_nowhere_else(corners: list[tuple[float, ...]]) -> None:
    boxes = tuple(Box(min(a, c), min(b, d), max(a, c) + 0.01, max(b, d) + 0.01) for a, b, c, d in corners)
    room = Room(Box(-1.0, -1.0, 1.0, 1.0), boxes)
    grid = map_of(room, DOCK)
    for (row, column), occupied in np.ndenumerate(grid.occupied):
        x, y = grid.centre(row, column)
        away = clearance(room, x, y)
        assert away <= math.hypot(CELL, CELL) / 2.0 + 1e-9 if occupied else away > 0.0


def test_the_workshop_fits_the_grid() -> None:
    sides = [getattr(box, side) for box in (FLOOR, *WORKSHOP.furniture) for side in Box.__slots__]
    assert [side for side in sides if abs(side / CELL - round(side / CELL)) > 1e-6] == []
    rows, columns = GRID.occupied.shape
    assert (columns * CELL, rows * CELL) == (pytest.approx(10.3), pytest.approx(8.3))


def test_obstacles_are_seen_and_not_on_the_map() -> None:
    simulation = Simulation(replace(IN_ROOM, start=Pose(-1.3), laser=LaserSettings(noise=0.0)))
    simulation.scanning = True
    simulation.set_fault(Fault.OBSTACLE, True)
    simulation.run(0.2)
    assert simulation.scan is not None
    assert simulation.scan.distances[180] < 0.75
    pillar = simulation.obstacles[0]
    assert not GRID.occupied[GRID.cell(pillar.x, pillar.y)]


def test_furniture_hides_the_marker() -> None:
    shelf = Room(FLOOR, (Box(-1.0, -0.5, -0.8, 0.5),))
    for room, seen in ((WORKSHOP, True), (shelf, False)):
        simulation = Simulation(Settings(start=Pose(-1.5), room=room))
        simulation.run(1.0)
        assert (simulation.detection is not None) is seen


def test_where_nothing_of_the_room_is_met_all_is_as_without_it() -> None:
    trails = []
    for room in (None, WORKSHOP):
        simulation, trail = Simulation(Settings(start=Pose(-1.2), room=room), seed=3), []
        while not simulation.charging:
            simulation.run(0.1, Velocity(0.2))
            trail.append((simulation.robot.pose, simulation.odometry.pose, simulation.detections, simulation.ranges))
        simulation.run(1.0, Velocity(0.2))
        assert simulation.robot.x == pytest.approx(DOCKED.x + 0.01)
        trails.append((trail, simulation.odometry.pose, simulation.touches))
    assert trails[0] == trails[1]
