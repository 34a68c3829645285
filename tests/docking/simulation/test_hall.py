"""The hall of a fleet: everything has room, whatever the number of robots and docks."""

import math
from itertools import combinations, pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from docking.core.geometry import Pose
from docking.simulation.dock import DOCKED, Dock, DockSettings
from docking.simulation.hall import Hall
from docking.simulation.occupancy import map_of
from docking.simulation.room import WORKSHOP
from docking.simulation.route import Routes
from docking.simulation.settings import check_docks
from robot_io.children import MAX_ROBOTS

RADIUS = 0.15
HALLS = st.integers(1, MAX_ROBOTS).flatmap(lambda robots: st.builds(Hall, st.just(robots), st.integers(1, robots)))


@settings(max_examples=40)
@given(HALLS)
def test_all_robots_start_apart_and_get_to_every_dock_and_place(hall: Hall) -> None:
    check_docks(hall.dock_places[1:])
    assert hall.dock_places[0] == 0.0
    room = WORKSHOP.extended(hall.room_extension)
    routes = Routes(map_of(room, Dock(DockSettings(), hall.dock_places[1:])), RADIUS)
    starts = [hall.start(robot) for robot in range(1, hall.robots + 1)]
    assert all(one.distance_to(other) >= 0.9 for one, other in combinations(starts, 2))
    staging = [hall.docked(dock).compose(Pose(-0.7)) for dock in range(1, hall.docks + 1)]
    goals = [*staging, *(pose for _, pose in room.places)]
    assert all(routes.is_free((pose.x, pose.y)) for pose in (*starts, *goals))
    for goal in goals:
        routes.find(starts[-1], (goal.x, goal.y))


@given(HALLS)
def test_each_dock_is_the_home_of_a_robot(hall: Hall) -> None:
    homes = [hall.home(robot) for robot in range(1, hall.robots + 1)]
    assert set(homes) == set(range(1, hall.docks + 1))
    assert hall.dock_names == tuple(f"dock{number}" for number in range(1, hall.docks + 1))
    for number, y in enumerate(hall.dock_places, 1):
        assert hall.docked(number) == Pose(DOCKED.x, y, DOCKED.theta)


def test_the_first_robots_stand_before_their_docks() -> None:
    hall = Hall(robots=3, docks=2)
    assert [hall.start(robot).y for robot in (1, 2, 3)] == [0.0, 1.0, -1.0]
    assert hall.dock_places == (0.0, 1.0)
    assert hall.room_extension == 0.0


@pytest.mark.parametrize("by", [0.0, 3.0])
def test_a_longer_room_keeps_its_furniture(by: float) -> None:
    room = WORKSHOP.extended(by)
    assert room.floor.y_max == WORKSHOP.floor.y_max + by
    assert len(room.furniture) == len(WORKSHOP.furniture)
    moved = [
        round(after.y_min - before.y_min, 6) for before, after in zip(WORKSHOP.furniture, room.furniture, strict=True)
    ]
    assert set(moved) == {0.0, by}
    workbench, cabinet = room.furniture[:2]
    assert workbench.y_max == cabinet.y_max == room.floor.y_max
    for name, pose in room.places:
        at_home = dict(WORKSHOP.places)[name]
        assert (pose.x, pose.theta) == (at_home.x, at_home.theta)
        assert pose.y - at_home.y == pytest.approx(by if at_home.y > 1.5 else 0.0)


def test_lanes_follow_each_other() -> None:
    places = sorted(Hall(MAX_ROBOTS, MAX_ROBOTS).dock_places)
    assert all(math.isclose(after - before, 1.0) for before, after in pairwise(places))
