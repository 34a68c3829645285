import math
from dataclasses import replace

import pytest

from docking.core.battery import BatteryReading
from docking.core.errors import ErrorCode, Stage
from docking.core.geometry import Pose
from docking.core.observation import STANDSTILL, Observation, Odometry
from docking.goal.engine import Command, End, Outcome
from docking.parameters import MotionLimits, UndockTimeouts
from docking.plans.undock import UndockGoal
from docking.simulation.dock import DOCKED
from docking.simulation.faults import Fault
from docking.simulation.simulation import Settings, Simulation

PERIOD = 0.05
MOTION = MotionLimits()


def docked() -> Simulation:
    simulation = Simulation(Settings(start=DOCKED), seed=4)
    simulation.run(0.5)
    assert simulation.charging
    return simulation


def undock(simulation: Simulation, limits: UndockTimeouts | None = None, *, keep_charging: bool = False) -> Outcome:
    goal = UndockGoal(0.7, MOTION, limits or UndockTimeouts(), simulation.time)
    speed, begun = 0.0, simulation.time
    while simulation.time < begun + 100.0:
        observation = simulation.observe()
        if keep_charging:
            observation = replace(observation, battery=BatteryReading(1, observation.now))
        step = goal.step(observation)
        if isinstance(step, Outcome):
            simulation.run(1.0, STANDSTILL)
            assert simulation.robot.velocity == STANDSTILL
            return step
        if step.stage is Stage.UNDOCKING:
            assert -MOTION.v_linear_max <= step.velocity.linear_x <= 0.0
            assert (
                abs(step.velocity.linear_x - speed) <= MOTION.a_linear_max * PERIOD + 1e-9
                or step.velocity == STANDSTILL
            )
            speed = step.velocity.linear_x
        simulation.run(PERIOD, step.velocity)
    raise AssertionError(f"still at {simulation.robot.pose}")


def test_it_backs_out_to_the_staging_pose_and_charges_no_longer() -> None:
    simulation = docked()
    assert undock(simulation) == Outcome(End.SUCCEEDED)
    assert not simulation.charging
    assert simulation.robot.pose.distance_to(Pose(-0.9)) < 0.05
    assert abs(simulation.robot.theta) < math.radians(5.0)


def test_a_robot_that_is_not_docked_has_succeeded_at_once_without_moving() -> None:
    simulation = Simulation(seed=4)
    begun = simulation.time
    assert undock(simulation) == Outcome(End.SUCCEEDED)
    assert simulation.time == pytest.approx(begun + 1.0)


def test_a_battery_that_goes_on_charging_is_a_failure() -> None:
    simulation = docked()
    outcome = undock(simulation, keep_charging=True)
    assert (outcome.end, outcome.error_code) == (End.ABORTED, ErrorCode.FAILED_TO_UNDOCK)
    assert "charging" in outcome.error_msg
    assert simulation.time < 23.0


def test_a_robot_that_is_held_fast_has_failed_to_undock() -> None:
    simulation = docked()
    simulation.set_fault(Fault.STUCK_WHEEL, True)
    outcome = undock(simulation)
    assert (outcome.end, outcome.error_code) == (End.ABORTED, ErrorCode.FAILED_TO_UNDOCK)
    assert "blocked_after" in outcome.error_msg
    assert simulation.time < 6.0


def test_a_way_that_takes_too_long_is_a_failure() -> None:
    outcome = undock(docked(), UndockTimeouts(undocking_timeout=1.0))
    assert outcome.error_code is ErrorCode.FAILED_TO_UNDOCK
    assert "did not get away" in outcome.error_msg


def test_without_odometry_it_does_not_move_and_gives_up() -> None:
    goal = UndockGoal(0.7, MOTION, UndockTimeouts(), 0.0)
    for number in range(10):
        now = 0.1 * number
        step = goal.step(Observation(now, BatteryReading(1, now)))
        assert isinstance(step, Command)
        assert step.velocity == STANDSTILL
    assert goal.step(Observation(1.1, BatteryReading(1, 1.1))).error_code is ErrorCode.ODOMETRY_LOST


def test_it_waits_for_a_silent_battery() -> None:
    goal, odometry = (
        UndockGoal(0.7, MOTION, UndockTimeouts(battery_lost_after=5.0), 0.0),
        Odometry(Pose(), STANDSTILL, 0.0),
    )
    step = goal.step(Observation(0.0, None, odometry))
    assert isinstance(step, Command)
    assert (step.stage, step.velocity) == (Stage.WAIT_FOR_BATTERY, STANDSTILL)
    assert goal.step(Observation(5.1, None, odometry)).error_code is ErrorCode.BATTERY_LOST


def test_the_first_outcome_stays() -> None:
    simulation = docked()
    goal = UndockGoal(0.7, MOTION, UndockTimeouts(), simulation.time)
    assert isinstance(goal.step(simulation.observe()), Command)
    canceled = goal.cancel()
    assert goal.step(simulation.observe()) is canceled
