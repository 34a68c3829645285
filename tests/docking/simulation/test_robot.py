import math
from dataclasses import replace
from random import Random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from docking.core.geometry import Pose
from docking.core.observation import STANDSTILL, Velocity
from docking.simulation.robot import Robot, RobotSettings
from docking.simulation.settings import Settings
from docking.simulation.simulation import Simulation

DT = 0.02
ORIGIN = Pose()
EXACT = RobotSettings(slip=0.0, slip_noise=0.0)
ANY = st.floats(allow_nan=True, allow_infinity=True)


def make_robot(settings: RobotSettings = EXACT, pose: Pose = ORIGIN) -> Robot:
    return Robot(settings, pose, Random(1))


def drive(robot: Robot, seconds: float, velocity: Velocity, **how: bool) -> None:
    for _ in range(round(seconds / DT)):
        robot.command(velocity)
        robot.step(DT, **how)


def test_it_drives_straight_as_far_as_it_is_told() -> None:
    robot = make_robot(pose=Pose(1.0, 2.0, math.pi / 2.0))
    drive(robot, 10.0, Velocity(0.2, 0.0))
    assert robot.x == pytest.approx(1.0)
    assert robot.y == pytest.approx(2.0 + 0.2 * 10.0, abs=0.03)  # the acceleration takes a moment
    assert robot.velocity == Velocity(0.2, 0.0)


def test_it_drives_a_circle() -> None:
    robot = make_robot()
    drive(robot, 1.0, Velocity(0.2, 0.5))
    start = robot.pose
    drive(robot, math.tau / 0.5 - 0.006, Velocity(0.2, 0.5))
    assert robot.pose.distance_to(start) < 0.01


def test_a_robot_that_skids_in_turns_turns_less_than_its_wheels() -> None:
    exact, skidding = make_robot(), make_robot(RobotSettings(slip=0.0, slip_noise=0.0, turn_slip=0.1))
    for robot in (exact, skidding):
        drive(robot, 1.0, Velocity(0.0, 0.5))
    assert skidding.theta == pytest.approx(0.9 * exact.theta)
    assert skidding.velocity == exact.velocity


def test_slip_loses_its_part_of_the_way() -> None:
    straight, slipping = make_robot(), make_robot(RobotSettings(slip=0.1, slip_noise=0.0))
    for robot in (straight, slipping):
        drive(robot, 5.0, Velocity(0.2, 0.0))
    assert slipping.x == pytest.approx(0.9 * straight.x)


def test_noise_grows_with_the_root_of_the_way() -> None:
    settings = RobotSettings(slip=0.0, slip_noise=0.01)
    ends = []
    for seed in range(300):
        robot = Robot(settings, Pose(), Random(seed))
        drive(robot, 1.0, Velocity(0.2, 0.0))
        ends.append(robot.theta)
    way = 0.18
    expected = 0.01 * math.sqrt(2.0 * way) / settings.wheel_separation
    assert math.sqrt(math.fsum(end * end for end in ends) / len(ends)) == pytest.approx(expected, rel=0.15)


@given(st.lists(st.tuples(ANY, ANY, st.integers(1, 20)), max_size=30), st.booleans())
def test_no_command_makes_it_leave_its_limits(commands: list[tuple[float, float, int]], stuck: bool) -> None:
    settings = RobotSettings()
    robot = make_robot(settings)
    for linear, angular, steps in commands:
        robot.command(Velocity(linear, angular))
        for _ in range(steps):
            before = robot.velocity
            robot.step(DT, stuck=stuck)
            assert robot.pose.finite
            assert abs(robot.linear) <= settings.linear_max
            assert abs(robot.angular) <= settings.angular_max
            assert abs(robot.linear - before.linear_x) <= settings.linear_acceleration * DT + 1e-12
            assert abs(robot.angular - before.angular_z) <= settings.angular_acceleration * DT + 1e-12


def test_it_brakes_less_than_it_accelerates() -> None:
    robot = make_robot(replace(EXACT, linear_braking=0.1, angular_braking=0.5))
    drive(robot, 0.5, Velocity(0.2, 1.0))
    assert robot.velocity == Velocity(0.2, 1.0)
    drive(robot, 1.0, STANDSTILL)
    assert (robot.linear, robot.angular) == (pytest.approx(0.1), pytest.approx(0.5))
    drive(robot, 1.1, Velocity(-0.2, 0.0))
    assert robot.linear == pytest.approx(-0.1, abs=0.03), "and it speeds up again on the other side"


def test_a_longer_bumper_touches_the_dock_earlier() -> None:
    simulation = Simulation(Settings(start=Pose(-0.6), robot=replace(EXACT, bumper=0.08)))
    while not simulation.touches:
        simulation.run(0.05, Velocity(0.04))
    assert simulation.robot.x == pytest.approx(-0.3, abs=0.003)
    assert simulation.contact
    for _ in range(40):
        simulation.run(0.05, Velocity(0.04))
    assert simulation.robot.x == pytest.approx(-0.27, abs=1e-6), "and the dock stops it"


@pytest.mark.parametrize("velocity", [Velocity(math.nan, 0.1), Velocity(0.1, math.inf)])
def test_a_velocity_that_is_no_number_does_not_count_as_a_command(velocity: Velocity) -> None:
    robot = make_robot()
    drive(robot, 0.3, Velocity(0.1, 0.0))
    drive(robot, 1.0, velocity)
    assert robot.velocity == STANDSTILL, "the last good command is too old"


def test_without_commands_it_stops_after_the_watchdogs_time() -> None:
    robot = make_robot()
    drive(robot, 1.0, Velocity(0.2, 0.0))
    still_driving = round(EXACT.cmd_vel_timeout / DT) - 1
    for _ in range(still_driving):
        robot.step(DT)
        assert robot.linear == 0.2
    for _ in range(2):
        robot.step(DT)
    assert robot.linear < 0.2
    for _ in range(round(0.2 / EXACT.linear_acceleration / DT)):
        robot.step(DT)
    assert robot.velocity == STANDSTILL


def test_halted_it_stops_whatever_it_is_told() -> None:
    robot = make_robot()
    drive(robot, 1.0, Velocity(0.2, 0.5))
    drive(robot, 0.5, Velocity(0.2, 0.5), halted=True)
    assert robot.velocity == STANDSTILL
    place = robot.pose
    drive(robot, 1.0, Velocity(0.2, 0.5), halted=True)
    assert robot.pose == place


def test_a_stuck_wheel_makes_it_pivot_and_then_the_motors_are_off_until_it_is_told_to_stand_still() -> None:
    robot = make_robot()
    drive(robot, 0.4, Velocity(0.2, 0.0), stuck=True)
    assert robot.angular > 0.1, "it turns around its left wheel"
    assert robot.left == pytest.approx(0.0, abs=1e-12)
    assert robot.stalled
    drive(robot, 1.0, Velocity(0.2, 0.0), stuck=True)
    assert robot.velocity == STANDSTILL
    drive(robot, 0.1, STANDSTILL, stuck=True)
    drive(robot, 0.3, Velocity(0.2, 0.0), stuck=True)
    assert robot.velocity != STANDSTILL
    drive(robot, 1.0, Velocity(0.2, 0.0))
    assert robot.velocity == Velocity(0.2, 0.0), "the wheel is free again"


def test_something_solid_takes_the_part_of_the_motion_that_goes_into_it() -> None:
    robot = make_robot(pose=Pose(0.0, 0.0, math.pi / 4.0))
    drive(robot, 1.0, Velocity(0.2, 0.0))
    robot.block(0.5, 0.6, -1.0, 0.0)
    assert (robot.x, robot.y) == (0.5, 0.6)
    assert robot.linear == pytest.approx(0.1), "half of it: 1 - cos² 45°"
    robot.block(0.5, 0.6, -1.0, 0.0)
    assert robot.linear == pytest.approx(0.1), "it goes on sliding"
    robot.block(0.5, 0.6, 1.0, 0.0)
    assert robot.linear == pytest.approx(0.1), "it drives away from what is behind it"


def test_placed_it_stands_still() -> None:
    robot = make_robot()
    drive(robot, 1.0, Velocity(0.2, 0.5))
    robot.place(Pose(-1.0, 2.0, 7.0))
    assert robot.velocity == STANDSTILL
    assert robot.pose == Pose(-1.0, 2.0, pytest.approx(7.0 - math.tau))


def test_in_the_dead_zone_nothing_moves() -> None:
    robot = make_robot(RobotSettings(slip=0.0, slip_noise=0.0, linear_dead_zone=0.05, angular_dead_zone=0.1))
    drive(robot, 1.0, Velocity(0.04, -0.09))
    assert robot.pose == ORIGIN
    drive(robot, 1.0, Velocity(-0.06, 0.09))
    assert robot.x < 0.0 == robot.theta


def test_a_wheel_that_is_larger_than_known_makes_a_curve() -> None:
    robot = make_robot(RobotSettings(slip=0.0, slip_noise=0.0, right_wheel_error=0.1))
    drive(robot, 2.0, Velocity(0.1))
    assert robot.left == robot.right, "the wheels turn alike"
    way = 0.1 * (2.0 - 0.05)
    assert robot.theta == pytest.approx(0.1 * way / 0.23, rel=0.02)
