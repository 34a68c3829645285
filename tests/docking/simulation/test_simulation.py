import math
from dataclasses import astuple, replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from docking.core.battery import PowerSupplyStatus
from docking.core.geometry import Pose
from docking.core.observation import STANDSTILL, Observation, Velocity
from docking.simulation.battery import BatteryMeasurement, BatterySettings
from docking.simulation.dock import DOCKED, DockSettings
from docking.simulation.faults import Fault
from docking.simulation.marker import MarkerSettings
from docking.simulation.obstacle import Obstacle
from docking.simulation.odometry import OdometrySettings
from docking.simulation.robot import RobotSettings
from docking.simulation.settings import Settings, check_docks
from docking.simulation.simulation import STEP, Simulation

IN_FRONT = Pose(-0.8, 0.0, 0.0)
EXACT = Settings(
    start=IN_FRONT,
    robot=RobotSettings(slip=0.0, slip_noise=0.0),
    odometry=OdometrySettings(drift=0.0),
    marker=MarkerSettings(noise=0.0, angle_noise=0.0, drop_outs=0.0),
)
COMMANDS = st.lists(st.tuples(st.floats(-0.5, 0.5), st.floats(-2.0, 2.0), st.integers(1, 60)), max_size=20)


def drive(simulation: Simulation, seconds: float, linear: float, angular: float = 0.0) -> None:
    for _ in range(round(seconds / 0.1)):
        simulation.run(0.1, Velocity(linear, angular))


def docked() -> Simulation:
    simulation = Simulation(replace(EXACT, start=DOCKED))
    simulation.run(0.2)
    return simulation


def battery_of(observation: Observation) -> BatteryMeasurement:
    assert observation.battery is not None
    assert isinstance(observation.battery.message, BatteryMeasurement)
    return observation.battery.message


def trace(seed: int, fault: Fault | None = None) -> list[object]:
    simulation = Simulation(seed=seed)
    if fault is not None:
        simulation.set_fault(fault, True)
    seen: list[object] = []
    for number in range(100):
        simulation.run(0.1, Velocity(0.15, 0.3 * math.sin(number)))
        seen.append((simulation.observe(), simulation.robot.pose))
    return seen


def test_the_same_seed_gives_the_same_and_another_one_something_else() -> None:
    assert trace(7) == trace(7)
    assert trace(7) != trace(8)


def test_a_fault_does_not_change_the_noise_of_the_rest() -> None:
    ways = [[pose for _, pose in trace(7, fault)] for fault in (None, Fault.OCCLUDED_MARKER)]
    assert ways[0] == ways[1]


def test_reset_begins_again() -> None:
    simulation = Simulation(seed=3)
    first = (simulation.observe(), simulation.robot.pose)
    drive(simulation, 3.0, 0.2, 0.1)
    simulation.set_fault(Fault.STUCK_WHEEL, True)
    simulation.halted = True
    simulation.reset()
    assert (simulation.observe(), simulation.robot.pose) == first
    assert simulation.faults == frozenset()
    assert simulation.halted, "a latched stop is not the simulation's to release"


@settings(max_examples=60)
@given(
    st.integers(0, 1000),
    st.floats(-0.7, 0.5),
    st.floats(-0.6, 0.6),
    st.floats(-math.pi, math.pi),
    COMMANDS,
)
def test_the_robot_never_gets_into_the_dock(
    seed: int, x: float, y: float, theta: float, commands: list[tuple[float, float, int]]
) -> None:
    simulation = Simulation(replace(EXACT, start=Pose(x, y, theta), robot=RobotSettings()), seed=seed)
    radius = simulation.robot.radius
    for linear, angular, steps in commands:
        for step in range(steps):
            simulation.step(STEP, Velocity(linear, angular) if step == 0 else None)
            robot = simulation.robot
            assert robot.pose.finite
            assert simulation.dock.clearance(robot.x, robot.y) >= radius - 1e-9
            assert abs(robot.linear) <= 0.3
            assert abs(robot.angular) <= 1.2
            assert simulation.contact == (
                math.hypot(robot.x + 0.2, robot.y) <= 0.02 and abs(robot.theta) <= math.radians(5.0)
            )


@pytest.mark.parametrize("start", [Pose(), Pose(0.05, 0.1, 2.0), Pose(-0.1, 0.0, 0.0), Pose(0.2, -0.2, 0.0)])
def test_nothing_is_set_down_in_the_dock(start: Pose) -> None:
    simulation = Simulation(replace(EXACT, start=start))
    for _ in range(2):
        robot = simulation.robot
        assert simulation.dock.clearance(robot.x, robot.y) >= robot.radius - 1e-9
        assert robot.theta == start.theta
        simulation.place(start)


def test_driven_straight_in_it_makes_contact_charges_and_is_held_by_the_dock() -> None:
    simulation = Simulation(EXACT)
    while not simulation.charging:
        assert simulation.time < 10.0
        assert not simulation.contact
        simulation.step(STEP, Velocity(0.1, 0.0))
    assert simulation.robot.x == pytest.approx(DOCKED.x - 0.02, abs=0.003)
    drive(simulation, 2.0, 0.2)
    assert simulation.robot.pose == Pose(pytest.approx(DOCKED.x + 0.01), 0.0, 0.0)
    assert simulation.odometry_velocity.linear_x == pytest.approx(0.0, abs=0.03), "the wheels stall"
    assert simulation.charging
    assert simulation.bumps == 0


def test_head_on_beside_the_contacts_it_bumps_once_and_stays_there() -> None:
    simulation = Simulation(replace(EXACT, start=Pose(-0.8, 0.1, 0.0)))
    drive(simulation, 6.0, 0.2)
    assert simulation.bumps == 1
    assert not simulation.contact
    assert simulation.robot.pose == Pose(pytest.approx(-0.19), pytest.approx(0.1), 0.0)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_at_the_corner_it_slides_off(side: float) -> None:
    simulation = Simulation(replace(EXACT, start=Pose(-0.8, 0.22 * side, 0.0)))
    drive(simulation, 8.0, 0.2)
    assert simulation.bumps == 1
    assert simulation.robot.x > 0.3, "past the dock"
    assert simulation.robot.y == pytest.approx(0.3 * side, abs=1e-6), "along its side"


def test_without_noise_odometry_and_truth_agree_until_the_robot_is_lifted() -> None:
    simulation = Simulation(EXACT)
    drive(simulation, 2.0, 0.2, 0.2)
    truth = simulation.robot.pose.relative_to(IN_FRONT)
    reckoned = simulation.odometry.pose
    assert astuple(reckoned) == pytest.approx(astuple(truth))
    simulation.place(Pose(-2.0, 0.0, 1.0))
    assert simulation.odometry.pose == reckoned


def test_odometry_drifts() -> None:
    simulation = Simulation(replace(EXACT, robot=RobotSettings(), odometry=OdometrySettings(0.01)), seed=1)
    drive(simulation, 10.0, -0.2)
    truth = simulation.robot.pose.relative_to(IN_FRONT)
    assert 0.01 < simulation.odometry.pose.distance_to(truth) < 0.3


def test_the_observed_marker_is_the_docks_in_odom() -> None:
    simulation = Simulation(EXACT)
    drive(simulation, 2.0, 0.1, 0.05)
    observation = simulation.observe()
    assert observation.marker is not None
    assert astuple(observation.marker.pose) == pytest.approx((0.8, 0.0, 0.0), abs=1e-9)


def test_observations_have_the_stamps_of_the_callers_clock() -> None:
    simulation = Simulation(EXACT)
    drive(simulation, 1.0, 0.1)
    observation = simulation.observe(5000.0)
    assert observation.now == 5000.0
    assert observation.marker is not None
    assert observation.infrared is not None
    assert observation.odometry is not None
    assert observation.battery is not None
    assert observation.odometry.stamp == 5000.0
    for stamp in (observation.marker.stamp, observation.infrared.stamp):
        assert 5000.0 - 1.0 / 15.0 - STEP <= stamp <= 5000.0
    assert observation.battery.age(5000.0) <= 0.1 + STEP


def test_a_marker_that_is_no_longer_seen_grows_old() -> None:
    simulation = Simulation(EXACT)
    simulation.run(1.0)
    simulation.set_fault(Fault.OCCLUDED_MARKER, True)
    simulation.run(2.0)
    observation = simulation.observe()
    assert observation.marker is not None
    assert observation.now - observation.marker.stamp >= 2.0 - 1e-6
    simulation.set_fault(Fault.OCCLUDED_MARKER, False)
    simulation.run(0.1)
    marker = simulation.observe().marker
    assert marker is not None
    assert marker.stamp > observation.marker.stamp


def test_pictures_come_fifteen_times_a_second() -> None:
    simulation = Simulation(EXACT)
    stamps = set()
    for _ in range(500):
        simulation.step()
        assert simulation.sightings
        stamps.add(simulation.sightings[-1].stamp)
    assert len(stamps) == pytest.approx(150, abs=1)


def test_the_first_observation_is_true_already() -> None:
    simulation = Simulation(replace(EXACT, start=DOCKED))
    measured = battery_of(simulation.observe())
    assert (measured.status, measured.current) == (PowerSupplyStatus.CHARGING, 6.5)
    assert battery_of(Simulation(EXACT).observe()).current < 0.0


def test_only_what_drives_into_the_dock_bumps() -> None:
    simulation = Simulation(replace(EXACT, start=Pose()))
    simulation.place(Pose(-0.1, 0.1, 0.0))
    simulation.run(0.1)
    assert simulation.bumps == 0


def test_docked_it_charges_and_pushed_off_it_discharges() -> None:
    simulation = docked()
    measured = battery_of(simulation.observe())
    assert measured.status is PowerSupplyStatus.CHARGING
    assert measured.current > 0.0
    simulation.push(Pose(-0.05, 0.0, 0.0))
    simulation.run(0.2)
    assert not simulation.contact
    measured = battery_of(simulation.observe())
    assert measured.status is PowerSupplyStatus.DISCHARGING
    assert measured.current < 0.0


def test_a_dead_charger_makes_contact_without_charge() -> None:
    simulation = docked()
    simulation.set_fault(Fault.DEAD_CHARGER, True)
    simulation.run(0.2)
    assert simulation.contact
    assert not simulation.charging
    measured = battery_of(simulation.observe())
    assert measured.status is PowerSupplyStatus.NOT_CHARGING
    assert measured.current < 0.0


def test_a_full_battery_is_full_on_the_dock() -> None:
    simulation = Simulation(replace(EXACT, start=DOCKED, battery=BatterySettings(battery_start=1.0)))
    simulation.run(1.0)
    assert battery_of(simulation.observe()).status is PowerSupplyStatus.FULL
    assert simulation.charging


def test_an_empty_battery_stops_the_robot() -> None:
    simulation = Simulation(replace(EXACT, battery=BatterySettings(battery_start=0.0)))
    drive(simulation, 1.0, 0.2)
    assert simulation.robot.pose == IN_FRONT


def test_a_silent_battery_says_nothing_new() -> None:
    simulation = Simulation(EXACT)
    simulation.run(1.0)
    before = simulation.observe().battery
    simulation.set_fault(Fault.SILENT_BATTERY, True)
    simulation.run(3.0)
    assert simulation.observe().battery == before
    assert simulation.observe().battery is not None


def test_a_percentage_of_a_hundred_is_a_percentage_times_a_hundred() -> None:
    simulation = Simulation(EXACT)
    simulation.set_fault(Fault.PERCENTAGE_0_TO_100, True)
    simulation.run(0.2)
    measured = battery_of(simulation.observe())
    assert measured.percentage == pytest.approx(24.0, rel=1e-3)
    assert measured.charge / measured.capacity == pytest.approx(0.24, rel=1e-3)


def test_driving_costs_more_than_standing_still_and_stalling_more_still() -> None:
    simulation = Simulation(EXACT)
    simulation.run(0.1)
    standing = simulation.battery.current
    drive(simulation, 1.0, 0.2)
    driving = simulation.battery.current
    simulation.place(Pose(-0.19, 0.1, 0.0))
    drive(simulation, 1.0, 0.2)
    stalling = simulation.battery.current
    assert stalling < driving < standing < 0.0


def test_halted_nothing_moves_it_but_a_push() -> None:
    simulation = Simulation(EXACT)
    simulation.halted = True
    drive(simulation, 1.0, 0.2)
    assert simulation.robot.pose == IN_FRONT
    simulation.push(Pose(-0.1, 0.0, 0.0))
    assert simulation.robot.x == pytest.approx(-0.9)


def test_a_run_takes_as_long_as_it_says() -> None:
    simulation = Simulation(EXACT)
    for seconds in (0.1, 0.033, 0.02, 0.0, 1.0):
        before = simulation.time
        simulation.run(seconds)
        assert simulation.time - before == pytest.approx(seconds)


def test_a_stop_is_a_command() -> None:
    simulation = Simulation(EXACT)
    drive(simulation, 1.0, 0.2)
    simulation.run(0.3, STANDSTILL)
    assert simulation.robot.velocity == STANDSTILL


def test_a_late_command_is_carried_out_late() -> None:
    simulation = Simulation(replace(EXACT, command_delay=0.2))
    moving = []
    for number in range(20):
        simulation.step(STEP, Velocity(0.2) if number == 0 else None)
        moving.append(simulation.robot.linear > 0.0)
    assert moving == [False] * 10 + [True] * 10


def test_the_fault_late_commands_delays_them() -> None:
    simulation = Simulation(EXACT)
    simulation.set_fault(Fault.LATE_COMMANDS, True)
    drive(simulation, 0.3, 0.2)
    assert simulation.robot.pose == IN_FRONT
    drive(simulation, 0.1, 0.2)
    assert simulation.robot.x > IN_FRONT.x


@pytest.mark.parametrize("honest", [True, False])
def test_late_odometry_is_that_of_earlier(honest: bool) -> None:
    late = Simulation(replace(EXACT, odometry=OdometrySettings(drift=0.0, delay=0.2, honest_stamps=honest)))
    prompt = Simulation(EXACT)
    poses = []
    assert late.observe().odometry is None
    for _ in range(30):
        poses.append(prompt.odometry.pose)
        for simulation in (late, prompt):
            simulation.step(STEP, Velocity(0.2, 0.1))
    odometry = late.observe().odometry
    assert odometry is not None
    assert odometry.pose == poses[20]
    assert odometry.stamp == pytest.approx(late.time), "when it arrived"


@pytest.mark.parametrize(("honest", "error"), [(True, 0.0), (False, 0.04)])
def test_a_late_detection_is_put_where_its_stamp_says(honest: bool, error: float) -> None:
    """At 0.2 m/s, a detection of 0.2 s ago with the stamp of now is 4 cm off."""
    marker = MarkerSettings(noise=0.0, angle_noise=0.0, drop_outs=0.0, delay=0.2, honest_stamps=honest)
    simulation = Simulation(replace(EXACT, marker=marker))
    drive(simulation, 2.0, 0.2)
    seen = simulation.observe().marker
    assert seen is not None
    assert seen.pose.x == pytest.approx(0.8 + error, abs=1e-6)


def test_odometry_without_twist_has_a_pose_alone() -> None:
    simulation = Simulation(replace(EXACT, odometry=OdometrySettings(drift=0.0, twist=False)))
    drive(simulation, 1.0, 0.2)
    odometry = simulation.observe().odometry
    assert odometry is not None
    assert odometry.velocity == STANDSTILL
    assert odometry.pose.x > 0.1


def test_contacts_that_bounce_charge_on_and_off_at_first() -> None:
    simulation = Simulation(replace(EXACT, start=Pose(-0.25), dock=DockSettings(bounce=1.0)))
    charging: list[tuple[float, bool]] = []
    for _ in range(200):
        simulation.step(STEP, Velocity(0.05))
        if simulation.contact:
            charging.append((simulation.time, simulation.charging))
    first = charging[0][0]
    assert {on for at, on in charging if at < first + 1.0} == {True, False}
    assert {on for at, on in charging if at > first + 1.0 + STEP} == {True}


def test_an_obstacle_stops_the_robot_and_counts_as_a_bump() -> None:
    simulation = Simulation(replace(EXACT, start=Pose(-1.5), obstacles=(Obstacle(-0.8, 0.0, 0.1),)))
    drive(simulation, 5.0, 0.2)
    assert simulation.robot.x == pytest.approx(-1.05, abs=1e-3)
    assert simulation.bumps == 1


def test_the_fault_obstacle_stands_in_front_of_the_dock() -> None:
    simulation = Simulation(replace(EXACT, start=Pose(-1.2)))
    simulation.run(0.2)
    seen = simulation.sightings[-1]
    simulation.set_fault(Fault.OBSTACLE, True)
    simulation.run(0.5)
    assert simulation.sightings[-1] == seen
    drive(simulation, 5.0, 0.2)
    assert simulation.robot.x < -0.7


def test_the_fault_worn_wheel_makes_curves_that_odometry_does_not_see() -> None:
    simulation = Simulation(EXACT)
    simulation.set_fault(Fault.WORN_WHEEL, True)
    drive(simulation, 1.0, 0.2)
    assert simulation.robot.theta < -0.05
    assert simulation.odometry.theta == 0.0


def test_the_fault_wrong_detections_moves_a_third_of_them() -> None:
    simulation = Simulation(EXACT, seed=1)
    simulation.set_fault(Fault.WRONG_DETECTIONS, True)
    seen = set()
    for _ in range(1000):
        simulation.step()
        assert simulation.sightings
        seen.add(simulation.sightings[-1])
    wrong = sum(sighting.marker.distance_to(Pose(0.8)) > 0.001 for sighting in seen)
    assert wrong / len(seen) == pytest.approx(1.0 / 3.0, abs=0.08)


@pytest.mark.parametrize("y", [0.0, 1.5, -2.0])
def test_each_of_several_docks_has_contacts_a_marker_a_beacon_and_is_solid(y: float) -> None:
    several = replace(EXACT, docks=(1.5, -2.0))
    here = Simulation(replace(several, start=Pose(DOCKED.x, y)))
    here.run(2.0)
    assert here.contact
    assert here.charging
    far = Simulation(replace(several, start=Pose(-0.8, y)))
    far.scanning = True
    drive(far, 4.0, 0.3)
    assert far.robot.x < 0.0, "it does not drive through"
    assert [touch.on_contacts for touch in far.touches] == [True]
    front = Simulation(replace(several, start=Pose(-0.8, y), marker=replace(several.marker, range=1.0)))
    front.run(0.5)
    assert front.detection is not None
    assert front.detection[1].distance_to(Pose(0.8)) < 1e-6
    assert front.ranges is not None
    assert front.ranges[1].center == pytest.approx(0.65, abs=0.05)


@pytest.mark.parametrize("places", [(0.2,), (1.0, 1.3), (math.nan,), (30.0,)])
def test_docks_that_stand_in_each_other_are_refused(places: tuple[float, ...]) -> None:
    with pytest.raises(ValueError, match=r"^is \["):
        check_docks(places)
