"""Ways on the map, and rides along them."""

import math
from itertools import pairwise

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from docking.core.geometry import Pose, normalize_angle
from docking.core.observation import STANDSTILL
from docking.simulation.box import Box
from docking.simulation.dock import DOCKED, Dock, DockSettings
from docking.simulation.faults import Fault
from docking.simulation.occupancy import map_of
from docking.simulation.ride import Ride
from docking.simulation.room import WORKSHOP, Room
from docking.simulation.route import NoWayError, Routes
from docking.simulation.settings import Settings
from docking.simulation.simulation import Simulation

RADIUS = 0.15
DOCK = Dock(DockSettings())
ROUTES = Routes(map_of(WORKSHOP, DOCK), RADIUS)
PLACES = st.tuples(st.floats(-9.6, 0.0), st.floats(-3.3, 4.3)).filter(ROUTES.is_free)
SOLIDS = (*WORKSHOP.furniture, *DOCK.boxes, WORKSHOP)


@settings(max_examples=60)
@given(PLACES, PLACES)
def test_a_way_keeps_clear_of_everything_from_its_start_to_its_goal(
    start: tuple[float, float], goal: tuple[float, float]
) -> None:
    way = ROUTES.find(Pose(*start), goal)
    assert (way[0], way[-1]) == (start, goal)
    for one, other in pairwise(way):
        count = math.ceil(math.dist(one, other) / 0.05) + 1
        for step in range(count + 1):
            x, y = (a + (b - a) * step / count for a, b in zip(one, other, strict=True))
            assert all(solid.obstruct(x, y, RADIUS) is None for solid in SOLIDS)


def drive(simulation: Simulation, target: Pose, longest: float = 120.0) -> Ride:
    ride = Ride(ROUTES, simulation.robot.pose, target, RADIUS, simulation.time)
    while (velocity := ride.step(simulation.robot.pose, simulation.obstacles, simulation.time)) is not None:
        simulation.run(1.0 / 30.0, velocity)
        assert simulation.time < longest
    simulation.run(0.5, STANDSTILL)
    return ride


@settings(max_examples=20)
@given(PLACES, PLACES, st.floats(-math.pi, math.pi), st.integers(0, 100))
@example((-1.0, 0.0), (-1.0, 0.047), 0.0, 0)  # it steers slowly where it is centimetres beside its goal
def test_a_ride_touches_nothing_and_ends_where_it_should(
    start: tuple[float, float], goal: tuple[float, float], heading: float, seed: int
) -> None:
    simulation = Simulation(Settings(start=Pose(*start, heading), room=WORKSHOP), seed)
    drive(simulation, Pose(*goal, -heading))
    assert simulation.bumps == 0
    assert simulation.robot.pose.distance_to(Pose(*goal)) < 0.06
    assert abs(normalize_angle(simulation.robot.theta + heading)) < 0.05


@pytest.mark.parametrize("seed", range(3))
def test_a_docked_robot_backs_out_and_drives_into_the_store(seed: int) -> None:
    simulation, target = Simulation(Settings(start=DOCKED, room=WORKSHOP), seed), Pose(-8.8, 3.0, 1.0)
    drive(simulation, target)
    assert simulation.bumps == 0
    assert simulation.robot.pose.distance_to(target) < 0.06
    assert abs(normalize_angle(simulation.robot.theta - target.theta)) < 0.05


def test_an_obstacle_ends_a_ride_before_it_is_touched() -> None:
    simulation = Simulation(Settings(start=Pose(-1.5), room=WORKSHOP))
    simulation.set_fault(Fault.OBSTACLE, True)
    with pytest.raises(NoWayError, match="an obstacle is in the way"):
        drive(simulation, Pose(-0.35))
    simulation.run(1.0, STANDSTILL)
    assert simulation.bumps == 0
    drive(simulation, Pose(-2.0, 0.5))


def test_a_robot_that_does_not_get_on_gives_up() -> None:
    simulation = Simulation(Settings(start=Pose(-1.5), room=WORKSHOP))
    simulation.halted = True
    with pytest.raises(NoWayError, match="did not get on for 10 s"):
        drive(simulation, Pose(-2.5))


def test_where_there_is_no_way_a_sentence_says_why() -> None:
    with pytest.raises(NoWayError, match=r"there is no room for the robot at \(-3.20, -2.00\)"):
        ROUTES.find(Pose(-1.0), (-3.2, -2.0))
    with pytest.raises(NoWayError, match="there is no room for the robot"):
        ROUTES.find(Pose(-1.0), (50.0, 0.0))
    with pytest.raises(NoWayError, match="the robot has no room to turn"):
        ROUTES.find(Pose(5.0, 5.0), (-1.0, 0.0))
    divided = Room(Box(-5.0, -1.0, 1.0, 1.0), (Box(-3.0, -1.0, -2.9, 1.0),))
    with pytest.raises(NoWayError, match=r"no way leads to \(-4.00, 0.00\)"):
        Routes(map_of(divided, DOCK), RADIUS).find(Pose(-1.0), (-4.0, 0.0))
