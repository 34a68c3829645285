"""Other robots in the room: they are seen, they block, and they never push."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from docking.core.geometry import Pose
from docking.core.observation import STANDSTILL, Velocity
from docking.simulation.dock import DOCKED, Dock, DockSettings
from docking.simulation.laser import LaserSettings
from docking.simulation.obstacle import Obstacle
from docking.simulation.occupancy import map_of
from docking.simulation.others import SILENT, Others, not_pushing
from docking.simulation.ride import LONGEST_WAIT, Ride
from docking.simulation.room import WORKSHOP
from docking.simulation.route import NoWayError, Routes
from docking.simulation.settings import Settings
from docking.simulation.simulation import Simulation

RADIUS = 0.15
ROUTES = Routes(map_of(WORKSHOP, Dock(DockSettings())), RADIUS)


def body(x: float, y: float) -> Obstacle:
    return Obstacle(x, y, RADIUS, low=True)


def test_a_robot_that_says_nothing_is_forgotten() -> None:
    others = Others()
    others.hear("robot2", -1.0, 0.5, 10.0)
    others.hear("robot3", -2.0, 0.5, 12.0)
    assert others.bodies(10.0 + SILENT) == (body(-1.0, 0.5), body(-2.0, 0.5))
    assert others.bodies(12.0 + SILENT) == (body(-2.0, 0.5),)
    others.hear("robot3", -2.5, 0.5, 13.0 + SILENT)
    assert others.bodies(13.0 + SILENT) == (body(-2.5, 0.5),)


@settings(max_examples=60)
@given(st.lists(st.tuples(st.floats(-3.0, 0.0), st.floats(-1.0, 1.0)), min_size=1, max_size=4))
def test_a_robot_that_stands_is_never_pushed(places: list[tuple[float, float]]) -> None:
    simulation = Simulation(Settings(start=Pose(-1.5), room=WORKSHOP))
    at = simulation.robot.pose
    for place in places:
        simulation.meet([body(*place)])
        simulation.run(0.1)
        assert simulation.robot.pose == at


@pytest.mark.parametrize("bearing", [0.0, 0.2, -0.2])
def test_a_robot_that_drives_is_blocked_and_seen(bearing: float) -> None:
    simulation = Simulation(Settings(start=Pose(-2.0, 0.0, bearing), laser=LaserSettings(noise=0.0)))
    other = body(-2.0 + math.cos(bearing), math.sin(bearing))
    simulation.scanning = True
    simulation.meet([other])
    simulation.run(0.2)
    assert simulation.scan is not None
    assert simulation.scan.distances[180] == pytest.approx(1.0 - RADIUS, abs=0.01)
    for _ in range(40):
        simulation.meet([other])
        simulation.run(0.1, Velocity(0.3))
        assert simulation.robot.pose.distance_to(Pose(other.x, other.y)) >= 2 * RADIUS - 1e-6
    assert simulation.bumps == 1


def test_a_robot_on_the_dock_does_not_hide_the_marker() -> None:
    simulation = Simulation(Settings(start=Pose(-1.5)))
    simulation.meet([body(DOCKED.x, DOCKED.y)])
    simulation.run(1.0)
    assert simulation.detection is not None


def test_a_robot_that_is_set_down_on_another_one_ends_up_beside_it() -> None:
    simulation = Simulation(Settings(start=Pose(-3.0), room=WORKSHOP))
    simulation.meet([body(-1.5, 0.0)])
    simulation.place(Pose(-1.45))
    assert simulation.robot.pose.distance_to(Pose(-1.5)) >= 2 * RADIUS - 1e-6
    again = Simulation(Settings(start=Pose(-1.45), room=WORKSHOP), others=(body(-1.5, 0.0),))
    assert again.robot.pose.distance_to(Pose(-1.5)) >= 2 * RADIUS - 1e-6


@given(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0))
def test_a_body_that_overlaps_ends_where_the_robot_begins(x: float, y: float) -> None:
    room = math.hypot(x, y) - RADIUS
    seen = not_pushing([body(x, y)], 0.0, 0.0, RADIUS)
    assert [each.radius for each in seen] == ([min(RADIUS, room)] if room > 0.0 else [])


def drive(simulation: Simulation, ride: Ride, others: list[Obstacle], longest: float = 90.0) -> None:
    while True:
        simulation.meet(others)
        velocity = ride.step(simulation.robot.pose, simulation.fixed_obstacles, simulation.time, simulation.others)
        if velocity is None:
            return
        simulation.run(1.0 / 30.0, velocity)
        assert simulation.time < longest


@pytest.mark.parametrize("y", [-0.2, 0.0, 0.2])
def test_a_ride_leads_around_a_robot_in_the_way(y: float) -> None:
    simulation, target = Simulation(Settings(start=Pose(-4.5), room=WORKSHOP)), Pose(-1.0, 0.0, 0.0)
    ride = Ride(ROUTES, simulation.robot.pose, target, RADIUS, simulation.time)
    drive(simulation, ride, [body(-2.5, y)])
    assert simulation.bumps == 0
    assert simulation.robot.pose.distance_to(target) < 0.06


def test_a_ride_waits_until_a_robot_has_gone() -> None:
    simulation, target = Simulation(Settings(start=Pose(-2.5), room=WORKSHOP)), Pose(-1.0, 0.0, 0.0)
    ride = Ride(ROUTES, simulation.robot.pose, target, RADIUS, simulation.time)
    others = [body(target.x, target.y)]
    while simulation.time < 20.0:
        simulation.meet(others)
        velocity = ride.step(simulation.robot.pose, (), simulation.time, simulation.others)
        simulation.run(1.0 / 30.0, velocity)
    assert velocity == STANDSTILL
    drive(simulation, ride, [])
    assert simulation.bumps == 0
    assert simulation.robot.pose.distance_to(target) < 0.06


def test_a_ride_gives_up_where_a_robot_stays_at_its_end() -> None:
    simulation, target = Simulation(Settings(start=Pose(-2.5), room=WORKSHOP)), Pose(-1.0, 0.0, 0.0)
    ride = Ride(ROUTES, simulation.robot.pose, target, RADIUS, simulation.time)
    with pytest.raises(NoWayError, match=f"another robot was in the way for {LONGEST_WAIT:g} s"):
        drive(simulation, ride, [body(target.x, target.y)])
    assert simulation.bumps == 0


@pytest.mark.parametrize("offset", [0.0, 0.05])
def test_two_robots_that_meet_get_past_each_other(offset: float) -> None:
    starts, targets = [Pose(-4.5, offset), Pose(-1.0, 0.0, math.pi)], [Pose(-1.0, 0.0), Pose(-4.5, offset, math.pi)]
    robots = [Simulation(Settings(start=start, room=WORKSHOP), seed) for seed, start in enumerate(starts)]
    rides: list[Ride | None] = [
        Ride(ROUTES, robot.robot.pose, target, RADIUS, 0.0, patience=1.0 + number)
        for number, (robot, target) in enumerate(zip(robots, targets, strict=True))
    ]
    while any(rides):
        for number, (robot, other) in enumerate(zip(robots, reversed(robots), strict=True)):
            robot.meet([body(other.robot.x, other.robot.y)])
            ride = rides[number]
            velocity = ride and ride.step(robot.robot.pose, (), robot.time, robot.others)
            rides[number] = None if velocity is None else ride
            robot.run(1.0 / 30.0, velocity or STANDSTILL)
        assert robots[0].time < 90.0
    assert [robot.bumps for robot in robots] == [0, 0]
