"""Omnidirectional bases: they correct sideways before the dock, and nothing changes for the others."""

import math
from dataclasses import replace
from random import Random

import numpy as np
import pytest
from benchmarks.docking.cases import CASES
from benchmarks.docking.trial import run_trial, settings_of
from hypothesis import given, settings
from hypothesis import strategies as st

from docking.behaviors.approach import FARTHEST_ASIDE, Approach
from docking.behaviors.combined import Reversed
from docking.core.errors import FailedToControl, LostMarker
from docking.core.geometry import Pose
from docking.core.observation import STANDSTILL, Observation, Odometry, Velocity
from docking.estimation.clearance import Clearance
from docking.goal.behavior import Failed
from docking.goal.pace import Limiter
from docking.goal.plan import DockTarget
from docking.parameters import ApproachSettings, ControllerName, DockSettings, MotionLimits
from docking.parameters.limits import DriveModel
from docking.simulation.robot import Robot, RobotSettings
from docking.simulation.settings import Settings
from docking.simulation.simulation import Simulation

DIFFERENTIAL, OMNI = MotionLimits(), MotionLimits(motion_model=DriveModel.OMNI)
PUSHED = "omnidirectional base, pushed 10 cm sideways in the last 20 cm"
ROWS = {case.name: case for case in CASES}
VELOCITIES = st.lists(
    st.builds(Velocity, st.floats(-2.0, 2.0), st.floats(-4.0, 4.0), st.floats(-2.0, 2.0)), min_size=1, max_size=20
)


@settings(max_examples=3, derandomize=True, deadline=None)
@given(st.integers(0, 10**6))
def test_a_robot_that_is_pushed_aside_before_its_dock_docks_without_a_retry(seed: int) -> None:
    trial = run_trial(ControllerName.DOCK_POSE, seed, ROWS[PUSHED])
    assert (trial.docked, trial.retries, trial.bumps) == (True, 0, 0)
    assert max(trial.contacts) <= settings_of(ControllerName.DOCK_POSE).motion.v_linear_min + 1e-9


@given(VELOCITIES)
def test_a_differential_drive_is_never_commanded_sideways(desired: list[Velocity]) -> None:
    limiter = Limiter(DIFFERENTIAL)
    assert all(limiter.limit(one, 0.05).linear_y == 0.0 for one in desired)


@given(VELOCITIES)
def test_velocity_and_acceleration_to_the_side_are_limited(desired: list[Velocity]) -> None:
    limiter, last = Limiter(OMNI), 0.0
    for one in desired:
        sideways = limiter.limit(one, 0.05).linear_y
        assert abs(sideways) <= OMNI.v_linear_max
        assert abs(sideways - last) <= OMNI.a_linear_max * 0.05 + 1e-9
        last = sideways


def test_an_obstacle_at_the_side_is_in_the_way_of_a_robot_that_drives_there() -> None:
    clearance = Clearance(((0.1, 0.1), (-0.1, 0.1), (-0.1, -0.1), (0.1, -0.1)), 0.0)
    beside = np.array(((0.0, 0.3),))
    assert clearance.contact(beside, Velocity(linear_y=0.1), 4.0) == pytest.approx(2.0, abs=0.06)
    assert clearance.contact(beside, Velocity(linear_y=-0.1), 4.0) == math.inf
    assert clearance.contact(beside, Velocity(0.1, 0.0, 0.1), 1.0) == math.inf


def test_a_base_with_a_steering_axle_is_refused_with_a_sentence() -> None:
    ackermann = replace(DIFFERENTIAL, motion_model=DriveModel.ACKERMANN)
    conflict = DockSettings(motion=ackermann).find_conflict()
    assert conflict is not None
    assert "docking turns on the spot" in conflict
    assert DockSettings(motion=OMNI).find_conflict() is None


@pytest.mark.parametrize(("timeout", "fault", "stands"), [(0.5, False, True), (0.0, False, False), (0.5, True, False)])
def test_the_command_timeout_of_the_simulated_base_counts_sideways_too(
    timeout: float, fault: bool, stands: bool
) -> None:
    robot = Robot(RobotSettings(omnidirectional=True, cmd_vel_timeout=timeout), Pose(), Random(1))
    robot.command(Velocity(linear_y=0.1))
    for _ in range(100):
        robot.step(0.02, goes_on=fault)
    assert robot.velocity == (STANDSTILL if stands else Velocity(linear_y=0.1))


@pytest.mark.parametrize(("omnidirectional", "y"), [(False, 0.0), (True, 0.2)])
def test_the_simulated_base_drives_sideways_if_it_can(omnidirectional: bool, y: float) -> None:
    robot = RobotSettings(omnidirectional=omnidirectional, slip=0.0, slip_noise=0.0)
    simulation = Simulation(Settings(start=Pose(-1.0, 0.0, 0.0), robot=robot))
    for _ in range(20):
        simulation.run(0.1, Velocity(linear_y=0.1))
    assert simulation.robot.pose.y == pytest.approx(y, abs=0.01)
    assert simulation.odometry.pose.y == pytest.approx(y, abs=0.01)


class ToTheLeft:
    """A behavior that drives to the left."""

    def step(self, observation: Observation, dt: float) -> Velocity:
        return Velocity(0.1, 0.2, 0.3)


def test_reversed_the_left_is_the_right() -> None:
    assert Reversed(ToTheLeft()).step(Observation(0.0), 0.0) == Velocity(-0.1, 0.2, -0.3)


class Seen(DockTarget):
    """A dock that stays where it is."""

    docked = Pose()
    seen_at = 0.0


def test_a_robot_that_does_not_get_aside_does_not_go_on_for_ever() -> None:
    """Such as with an odometry that stands still: nobody knows how far it has driven."""
    dock = Seen()
    approach = Approach(dock, OMNI, ApproachSettings(), LostMarker, 1e9)
    odometry = Odometry(Pose(-0.2, 0.1), Velocity(), 0.0)
    sideways = 0.0
    for number in range(600):
        dock.seen_at = 0.05 * number
        step = approach.step(Observation(0.05 * number, odometry=odometry), 0.05)
        if isinstance(step, Failed):
            break
        assert isinstance(step, Velocity)
        sideways += abs(step.linear_y) * 0.05
    assert isinstance(step, Failed)
    assert isinstance(step.error, FailedToControl)
    assert sideways <= 2.0 * FARTHEST_ASIDE + 0.01
